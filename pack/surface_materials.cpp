#include "pack/surface_materials.h"

#include "pack/pack_transfer.h"

namespace penumbra {

void addSurfaceMaterials(SurfaceLook& look, int) {
    look.materials = {diffuseMaterial({1, 1, 1})};
}

}  // namespace penumbra
