#include "formats/image/negative_radiance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr int kCodecBlock = 8;  // pixels; the side of a block of the codec

struct Around {
    std::vector<std::size_t> pixels;
    double flux = 0, largest = 0;  // sum and maximum of the values above 0
};

Around lookAround(const EnvironmentMap& map, const std::vector<double>& steradians, int x, int y, int channel) {
    Around around;
    const int width = map.image.width;
    for (int j = std::max(0, y - kCodecBlock); j <= std::min(map.image.height - 1, y + kCodecBlock); ++j)
        for (int i = x - kCodecBlock; i <= x + kCodecBlock; ++i) {
            if ((i < 0 || i >= width) && map.layout != MapLayout::kLatLong) continue;
            const std::size_t at = std::size_t(j) * std::size_t(width) + std::size_t(((i % width) + width) % width);
            const double value = map.image.pixels[at][channel];
            if (!(value > 0) || steradians[at] == 0) continue;
            around.pixels.push_back(at);
            around.flux += value * steradians[at];
            around.largest = std::max(around.largest, value);
        }
    return around;
}

std::vector<double> pixelSteradians(const EnvironmentMap& map) {
    std::vector<double> steradians;
    for (int y = 0; y < map.image.height; ++y)
        for (int x = 0; x < map.image.width; ++x) steradians.push_back(mapSteradians(map.shape(), x + 0.5, y + 0.5));
    return steradians;
}

}  // namespace

NegativeRadiance removeNegativeRadiance(EnvironmentMap& map, const std::string& name) {
    constexpr double kRinging = 0.5;
    std::vector<Vec3>& pixels = map.image.pixels;
    if (std::all_of(pixels.begin(), pixels.end(), [](Vec3 p) { return p.x >= 0 && p.y >= 0 && p.z >= 0; })) return {};
    const std::vector<double> steradians = pixelSteradians(map);
    NegativeRadiance found;
    double below = 0, above = 0;
    for (std::size_t at = 0; at < pixels.size(); ++at) {
        if (at % std::size_t(map.image.width) == 0) throwIfInterrupted();
        bool negative = false;
        for (int channel = 0; channel < 3; ++channel) {
            const double value = pixels[at][channel], flux = steradians[at] * std::abs(value);
            (value < 0 ? below : above) += flux;
            if (value >= 0) continue;
            pixels[at][channel] = 0;
            if (flux == 0) continue;  // off the light
            negative = true;
            const int x = int(at % std::size_t(map.image.width)), y = int(at / std::size_t(map.image.width));
            const Around around = lookAround(map, steradians, x, y, channel);
            if (-value > kRinging * around.largest || flux > around.flux)
                throw InvalidInput(name + ": negative radiance, " + std::to_string(value) + " in pixel (" +
                                   std::to_string(x) + ", " + std::to_string(y) +
                                   "), and nothing bright enough beside it to be ringing of compression");
            for (std::size_t i : around.pixels) pixels[i][channel] *= float(1 - flux / around.flux);
        }
        found.pixels += negative;
    }
    found.share = below > 0 ? below / (below + above) : 0;
    return found;
}

}  // namespace penumbra
