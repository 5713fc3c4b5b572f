#include "bake/reference/light_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

constexpr double kPi = std::numbers::pi;

// Returns the steradians of one pixel of row y.
double latLongSolidAngle(const MapShape& shape, int y) {
    return 2 * kPi / shape.width * (std::cos(kPi * y / shape.height) - std::cos(kPi * (y + 1) / shape.height));
}

// Returns the solid angle of a pixel, nearly. That is enough, because draws in proportion to it are weighted with the
// exact density. A pixel that the rim cuts counts with what nine of its points see.
double solidAngle(const MapShape& shape, int x, int y) {
    if (shape.layout == MapLayout::kLatLong) return latLongSolidAngle(shape, y);
    double sum = 0;
    for (double v : {0.05, 0.5, 0.95})
        for (double u : {0.05, 0.5, 0.95}) sum += mapSteradians(shape, x + u, y + v);
    return sum / 9;
}

}  // namespace

LightTable makeLightTable(const MapShape& shape, std::span<const double> radiance) {
    assert(radiance.size() == std::size_t(shape.width) * std::size_t(shape.height));
    LightTable table{shape, std::vector<double>(radiance.size() + 1, 0.0), 0};
    for (std::size_t i = 0; i < radiance.size(); ++i)
        table.cumulative[i + 1] =
            table.cumulative[i] +
            radiance[i] * solidAngle(shape, int(i % std::size_t(shape.width)), int(i / std::size_t(shape.width)));
    table.power = table.cumulative.back();
    for (std::size_t i = 0; i < table.cumulative.size(); ++i)  // for a black light any density will do
        table.cumulative[i] = table.power > 0 ? table.cumulative[i] / table.power : double(i) / double(radiance.size());
    return table;
}

LightSample sampleTable(const LightTable& table, double u, double v) {
    const std::vector<double>& cumulative = table.cumulative;
    // The pixel whose share of [0, 1) holds u.
    const auto above = std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, u);
    const auto pixel = std::size_t(above - cumulative.begin()) - 1;
    const double chance = cumulative[pixel + 1] - cumulative[pixel];
    const MapShape& shape = table.shape;
    const int y = int(pixel / std::size_t(shape.width)), x = int(pixel % std::size_t(shape.width));
    // The rest of u is uniform within the pixel.
    const double across = chance > 0 ? std::clamp((u - cumulative[pixel]) / chance, 0.0, 1.0) : 0.5;
    if (shape.layout == MapLayout::kLatLong) {  // the height in a lat-long pixel must be uniform in the cosine
        const double top = std::cos(kPi * y / shape.height), bottom = std::cos(kPi * (y + 1) / shape.height);
        const double polar = std::acos(std::clamp(top + (bottom - top) * v, -1.0, 1.0)) / kPi;
        return {latLongDirection((x + across) / shape.width, polar), chance / latLongSolidAngle(shape, y)};
    }
    const double steradians = mapSteradians(shape, x + across, y + v);
    if (steradians <= 0) return {};
    return {mapDirection(shape, x + across, y + v), chance / steradians};
}

double densityOf(const LightTable& table, Vec3d direction) {
    const MapShape& shape = table.shape;
    const MapPixel at = mapPixel(shape, direction);
    const std::size_t pixel = std::size_t(at.y) * std::size_t(shape.width) + std::size_t(at.x);
    const double chance = table.cumulative[pixel + 1] - table.cumulative[pixel];
    return chance /
           (shape.layout == MapLayout::kLatLong ? latLongSolidAngle(shape, at.y) : mapSteradians(shape, direction));
}

}  // namespace penumbra
