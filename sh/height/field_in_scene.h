#pragma once
// Where a height field stands in a scene, whose y is up: its columns go along x, its rows along z, its heights along y.
#include "sh/height/height_field.h"

namespace penumbra {

// y of the field at a place of the scene, on its triangles. `corner` is where height 0 of row 0 and column 0 stands.
double heightOfField(const HeightField& field, Vec3d corner, double x, double z);

}  // namespace penumbra
