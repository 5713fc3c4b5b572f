#include "sh/height/field_in_scene.h"

namespace penumbra {

double heightOfField(const HeightField& field, Vec3d corner, double x, double z) {
    return corner.y +
           field.onTriangles((z - corner.z) / double(field.grid().cell_x), (x - corner.x) / double(field.grid().cell_y));
}

}  // namespace penumbra
