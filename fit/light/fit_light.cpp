#include "fit/light/fit_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>

namespace penumbra {

namespace {

double squareOf(std::span<const double> values) {
    return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
}

// Makes a light of SH coefficients and of the energy |L|^2 of the whole light. The projection is orthogonal, so |L -
// SH|^2 = |L|^2 - |SH|^2.
LightFile makeLight(const std::string& name, int order, std::vector<double> sh, double energy) {
    LightFile light;
    light.name = name;
    light.order = order;
    light.residual = energy > 0 ? std::sqrt(std::max(0.0, 1 - squareOf(sh) / energy)) : 0;
    light.sh = std::move(sh);
    return light;
}

}  // namespace

LightFile fitLight(const EnvironmentMap& map, const std::string& name, int order, int threads) {
    return fitLight(projectMap(map, order, threads), name, order);
}

LightFile fitLight(MapProjection projection, const std::string& name, int order) {
    return makeLight(std::filesystem::path(name).filename().string(), order, std::move(projection.sh),
                     projection.energy);
}

LightFile fitLight(std::span<const AnalyticLight> lights, const std::string& name, int order) {
    const LightParts parts = partsOf(lights);
    return makeLight(name, order, projectLights(parts, order), energyOf(parts));
}

namespace {

double luminanceOf(Vec3 rgb) { return 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z; }

constexpr int kSpot = 2, kEdge = kSpot + 1;  // number of rings around a pixel

// The surroundings of a pixel by ring: the largest luminance in each, and the sum, both as multiples of the pixel's
// own.
struct Rings {
    std::array<double, kEdge + 1> largest{}, sum{};
    double flux = 0;  // flux of the spot
};

Rings ringsAround(const EnvironmentMap& map, int x, int y) {
    const int width = map.image.width, height = map.image.height;
    const auto luminance = [&](int i, int j) {
        return luminanceOf(map.image.pixels[std::size_t(j) * std::size_t(width) + std::size_t(i)]);
    };
    Rings rings;
    for (int j = std::max(0, y - kEdge); j <= std::min(height - 1, y + kEdge); ++j)
        for (int i = x - kEdge; i <= x + kEdge; ++i) {
            // A lat-long picture continues at its other side.
            const bool around = map.layout == MapLayout::kLatLong && width > 2 * kEdge;
            if ((i < 0 || i >= width) && !around) continue;
            const int column = (i + width) % width, ring = std::max(std::abs(i - x), std::abs(j - y));
            const double value = luminance(column, j), relative = value / luminance(x, y);
            rings.largest[std::size_t(ring)] = std::max(rings.largest[std::size_t(ring)], relative);
            rings.sum[std::size_t(ring)] += relative;
            if (ring <= kSpot) rings.flux += value * mapSteradians(map.shape(), column + 0.5, j + 0.5);
        }
    return rings;
}

}  // namespace

HotPixel findHotPixel(const EnvironmentMap& map) {
    constexpr double kShare = 0.05, kAlone = 0.1, kMaxPixels = 6, kSharp = 0.002;
    // 1. Find the pixel with the most flux, and the flux of the whole picture.
    HotPixel brightest;
    double whole = 0, most = 0;
    for (int y = 0; y < map.image.height; ++y) {
        const double of_row = mapSteradians(map.shape(), 0.5, y + 0.5);  // a lat-long row has the same everywhere
        for (int x = 0; x < map.image.width; ++x) {
            const Vec3 pixel = map.image.pixels[std::size_t(y) * std::size_t(map.image.width) + std::size_t(x)];
            const double flux =
                luminanceOf(pixel) *
                (map.layout == MapLayout::kLatLong ? of_row : mapSteradians(map.shape(), x + 0.5, y + 0.5));
            whole += flux;
            if (flux > most) most = flux, brightest = {x, y, 0};
        }
    }
    if (!(most > 0)) return brightest;
    // 2. See whether it shines alone or belongs to a sharp spot.
    const Rings rings = ringsAround(map, brightest.x, brightest.y);
    if (most >= kShare * whole && rings.largest[1] < kAlone) {
        brightest.share = most / whole;
    } else if (rings.flux >= kShare * whole && rings.largest[kEdge] < kSharp &&
               std::accumulate(rings.sum.begin(), rings.sum.end() - 1, 0.0) <= kMaxPixels) {
        brightest.share = rings.flux / whole;
        brightest.alone = false;
    }
    return brightest;
}

WindowReport windowFit(const WindowChoice& choice, const HotPixel& hot, LightFile& light) {
    std::vector<double> change = light.sh;
    const bool always = choice.mode == WindowChoice::Mode::kAuto && hot.share > 0;
    WindowReport report =
        windowLight(light.order, always ? WindowChoice{WindowChoice::Mode::kAlways, 0} : choice, light.sh);
    if (!report.any()) return report;
    light.window = report.weights;
    const double whole = squareOf(change);
    for (std::size_t i = 0; i < change.size(); ++i) change[i] -= light.sh[i];
    // |L|^2 is |SH|^2 / (1 - residual^2), and what the window took is orthogonal to what the projection left out.
    const double left = light.residual * light.residual;
    light.residual = std::sqrt(left + (1 - left) * squareOf(change) / whole);
    return report;
}

}  // namespace penumbra
