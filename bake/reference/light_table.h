#pragma once
// Draws directions in proportion to a table over the pixels of a picture of the sphere.
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
    std::vector<double> cumulative;  // [height * width + 1]: the share of all pixels before, row by row; the last is 1
    double power = 0;                // sum of radiance times steradians
};

// Makes a table of `radiance`, which has one number >= 0 for every pixel.
LightTable makeLightTable(const MapShape& shape, std::span<const double> radiance);
// Draws a direction; u, v in [0, 1). Draws are uniform over the solid angle of a lat-long pixel and over the area of
// any other pixel.
LightSample sampleTable(const LightTable& table, double u, double v);
// Returns the density per steradian with which sampleTable() draws this direction.
double densityOf(const LightTable& table, Vec3d direction);

}  // namespace penumbra
