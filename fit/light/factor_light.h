#pragma once
// Takes the suns out of a light: what `penumbra-fit light --factor` stores beside the SH.
#include <span>
#include <vector>

#include "fit/light/sun_picture.h"
#include "formats/image/environment_map.h"
#include "formats/stage/light_file.h"
#include "sh/light/analytic_light.h"

namespace penumbra {

struct FactorChoice {
    int suns = 1;  // at most, 1..kMaxSuns
    FactorMode mode = FactorMode::kHandOver;
    int picture_width = 128;  // of the picture without the suns, even, 0: none
};

// What was found, a row a sun of the file.
struct FactorReport {
    struct SunReport {
        double dominance = 1, share = 1;  // q and c of sh/light/dominant_light.h
        std::size_t flat_pixels = 0;      // of a picture: pixels at the peak (sun_picture.h)
    };
    std::vector<SunReport> suns;
    double clamped = 0;  // flux of the picture, as a part of all, that half floats cannot hold
};

// The suns are found in SH of this order, whatever order the file stores: at order 6 a sun is 0.2 to 0.4 degrees off,
// at order 4 a weak one 4 to 10 degrees.
constexpr int kFactorOrder = 6;

// Suns of a picture. kHandOver takes the direction of a sun from the brightest pixels and its irradiance from SH. Fills
// the suns, the picture and the mode of `light`.
FactorReport factorLight(const EnvironmentMap& map, const FactorChoice& choice, int threads, LightFile& light);
// Suns of analytic lights. kHandOver takes the brightest directional lights, suns and discs of up to kMostSunRadius as
// they are described. All of a disc's flux goes to its sun.
constexpr double kMostSunRadius = 10;  // degrees
FactorReport factorLight(std::span<const AnalyticLight> lights, const FactorChoice& choice, LightFile& light);

}  // namespace penumbra
