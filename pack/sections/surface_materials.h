#pragma once
// Makes the materials that the vertices of a surface with pictures are shaded with.
#include "pack/sections/surface_section.h"

namespace penumbra {

// Adds D, A and B of every slot (sh/brdf/principled.h) to the look, each once, and tells the slots which are theirs.
// `threads` as in parallelFor().
void addSurfaceMaterials(SurfaceLook& look, int threads);

}  // namespace penumbra
