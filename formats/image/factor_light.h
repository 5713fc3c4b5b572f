#pragma once
// Takes the suns out of a light: what `penumbra-fit light --factor` stores beside the SH, and what the window knows of
// a picture that it opens.
#include <span>
#include <string>
#include <vector>

#include "formats/image/sun_picture.h"
#include "sh/light/analytic_light.h"

namespace penumbra {

struct LightFactorChoice {
    int suns = 1;  // at most, 1..kMaxSuns
    FactorMode mode = FactorMode::kHandOver;
    int picture_width = 128;  // width of the picture without the suns, even; 0: none
};

// The suns that were found, one row each.
struct FactorReport {
    struct SunReport {
        // q and c of sh/light/dominant_light.h, c without what a wide sun loses; of several suns of a picture the
        // worth and the share of area_lights.h
        double dominance = 1, share = 1;
        std::size_t flat_pixels = 0;  // only for pictures: pixels at the peak (sun_picture.h)
    };
    std::vector<SunReport> suns;
    double clamped = 0;  // flux of the picture, as a part of all, that half floats cannot hold
};

struct LightSuns {
    std::vector<SunD> suns;
    std::string factor;    // how they were found: "hand-over", "paper" or "exact"
    LightPicture picture;  // the light without the suns
    FactorReport report;
};

// The suns are found in SH of this order, whatever order the file stores: at order 6 a sun is 0.2 to 0.4 degrees off,
// at order 4 a weak one 4 to 10 degrees.
constexpr int kFactorOrder = 6;

// Suns of a picture. Where more than one is allowed, kHandOver finds lights of up to 15 degrees in the picture itself
// (area_lights.h), as many as are worth a shadow of their own. One sun is found in SH: kHandOver takes the direction of
// a sun from the brightest pixels and its irradiance from SH. A sun of 15 degrees counts whole, one of 25 or more is
// none, and between them a part stays in the remainder.
LightSuns factorLight(const EnvironmentMap& map, const LightFactorChoice& choice, int threads);
// The same for a picture whose projection of kFactorOrder or more is known, `sh` [n^2, 3].
LightSuns factorLight(const EnvironmentMap& map, std::span<const double> sh, const LightFactorChoice& choice);
// Suns of analytic lights. kHandOver takes the brightest directional lights, suns and discs of up to kMaxSunRadius as
// they are described. All of a disc's flux goes to its sun.
constexpr double kMaxSunRadius = 10;  // degrees
LightSuns factorLight(std::span<const AnalyticLight> lights, const LightFactorChoice& choice);

}  // namespace penumbra
