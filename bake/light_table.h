#pragma once
// Directions drawn in proportion to a table over the pixels of a picture of the sphere.
#include <span>
#include <vector>

#include "formats/image/environment_map.h"

namespace penumbra {

struct LightSample {
    Vec3d direction;     // zero: this draw fell off the light (rim pixels of a disc) and counts as 0
    double density = 0;  // per steradian
};

struct LightTable {
    MapShape shape;
    std::vector<double> cumulative;  // [height * width + 1]: of all pixels before, row by row; the last is 1
    double power = 0;                // sum of radiance times steradians
};

// `radiance` >= 0 of every pixel.
LightTable makeLightTable(const MapShape& shape, std::span<const double> radiance);
// u, v in [0, 1). Uniform over the solid angle of a lat-long pixel, over the area of others.
LightSample sampleTable(const LightTable& table, double u, double v);
double densityOf(const LightTable& table, Vec3d direction);

}  // namespace penumbra
