#include "sh/height/horizon.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

constexpr double kLevelBias = 3.25;

// log2 of the distances in texels, up to that of the longer side.
std::vector<double> tapOctaves(double longest) {
    constexpr double kRounding = 1e-9;
    std::vector<double> out;
    for (double at = -2; at <= longest + kRounding;) {
        out.push_back(at);
        at += at < -kRounding ? 1 : at < 4 - kRounding ? 1.0 / 3 : 0.4;
    }
    return out;
}

}  // namespace

double horizonAzimuth(int a, int azimuths) { return 2 * std::numbers::pi * a / azimuths; }

HorizonTaps horizonTaps(const HeightField& field, int azimuths) {
    const HeightGrid& grid = field.grid();
    HorizonTaps out;
    const std::vector<double> all_octaves = tapOctaves(std::log2(std::max(grid.rows, grid.columns)));
    out.count = all_octaves.size();
    const int top = int(field.levels().size()) - 1;
    for (int a = 0; a < azimuths; ++a) {
        const double phi = horizonAzimuth(a, azimuths), x = std::cos(phi) / double(grid.cell_x),
                     // length of one texel in this direction
            y = std::sin(phi) / double(grid.cell_y), metres = 1 / std::hypot(x, y);
        for (const double octaves : all_octaves) {
            const double distance = std::exp2(octaves);
            const int level = int(std::nearbyint(octaves - kLevelBias));
            out.taps.push_back({float(distance * metres * x), float(distance * metres * y),
                                float(1 / (distance * metres)), std::clamp(level, 0, top)});
        }
    }
    return out;
}

}  // namespace penumbra
