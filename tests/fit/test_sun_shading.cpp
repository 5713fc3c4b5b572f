// The error of shading by sun and remainder on the reference scenes: a point sun over a sky, brute force with the true
// sun. The golden mixed_light.json has the figures of 31 other occluders of the same kinds, 18 views and 12 suns: all
// SH .168 and .498, factored .090 and .089. Here there are 61 occluders, 14 views and 12 suns.
#include <gtest/gtest.h>

#include <cmath>

#include "fit/reflectance/shading_scenes.h"
#include "sh/brdf/brdf.h"
#include "sh/light/dominant_light.h"
#include "sh/quadrature.h"

namespace penumbra::test_sun_shading {
namespace {

double skyRadianceAt(Vec3d d) { return d.z > 0 ? 1 - 0.5 * d.z : 0.3; }

// Squared differences of the two ways from the truth, and the square of the truth, summed.
struct Errors {
    double all = 0, factored = 0, truth = 0;
};

// What the occluders leave open, and their numbers of order 5 on a grid that integrates products exactly.
struct SunScenes {
    ShadingScenes scenes = referenceScenes();
    std::vector<WeightedDirection> half = gaussHemisphere(48, 192), whole = gaussSphere(12, 24);
    std::vector<std::vector<double>> open;          // [occluder, half]
    std::vector<std::vector<double>> coefficients;  // [occluder, whole] V of convention D, order 5
    std::vector<double> sky = std::vector<double>(16, 0.0);

    SunScenes() {
        const std::size_t kept = scenes.occluders.size();
        std::vector<double> y(25);
        for (const auto& [d, w] : gaussSphere(120, 240)) {
            evalBasis(4, d, std::span(y).first(16));
            for (std::size_t i = 0; i < 16; ++i) sky[i] += w * skyRadianceAt(d) * y[i];
        }
        for (std::size_t k = 0; k < kept; ++k) {
            std::vector<double> moments(25, 0.0), &see = open.emplace_back(), &v = coefficients.emplace_back();
            for (const auto& [d, w] : half) {
                see.push_back(isBlocked(scenes.occluders[k], d) ? 0 : 1);
                evalBasis(5, d, y);
                for (std::size_t i = 0; i < 25; ++i) moments[i] += w * see.back() * y[i];
            }
            for (const auto& [d, w] : whole) {
                evalBasis(5, d, y);
                double sum = 0;
                for (int l = 0; l < 5; ++l)
                    for (int m = -l; m <= l; ++m)
                        if ((l + m) % 2 == 0)
                            sum += 2 * moments[std::size_t(shIndex(l, m))] * y[std::size_t(shIndex(l, m))];
                v.push_back(sum);
            }
        }
    }

    void add(const RgbBrdf& brdf, Vec3d view, Vec3d sun, double irradiance, Errors& errors) const {
        std::vector<double> slices(25, 0.0), y(25), light = sky, truth_sky(half.size());
        for (std::size_t q = 0; q < half.size(); ++q) {
            const auto& [d, w] = half[q];
            const double f = brdf.eval(d, view).x * d.z;
            truth_sky[q] = w * f * skyRadianceAt(d);
            evalBasis(5, d, y);
            for (std::size_t i = 0; i < 25; ++i) slices[i] += w * f * y[i];
        }
        evalBasis(4, sun, std::span(y).first(16));
        for (std::size_t i = 0; i < 16; ++i) light[i] += irradiance * y[i];
        std::vector<double> rgb;
        for (const double value : light) rgb.insert(rgb.end(), 3, value);
        static LightFactor factor(4);
        const SunD found = factor.factor(rgb).candidates[0].sun;
        std::vector<double> rest = rgb;
        subtractSuns(std::span(&found, 1), {}, rest);
        // Slices times light on the grid of the products.
        std::vector<double> all(whole.size()), soft(whole.size());
        for (std::size_t s = 0; s < whole.size(); ++s) {
            const auto& [d, w] = whole[s];
            evalBasis(5, d, y);
            double f = 0, l = 0, g = 0;
            for (std::size_t i = 0; i < 25; ++i) f += slices[i] * y[i];
            for (std::size_t i = 0; i < 16; ++i) l += light[i] * y[i], g += rest[3 * i] * y[i];
            all[s] = w * f * l, soft[s] = w * f * g;
        }
        const auto direct = [&](Vec3d d, double e) { return d.z > 0 ? e * d.z * brdf.eval(d, view).x : 0; };
        for (std::size_t k = 0; k < open.size(); ++k) {
            double truth = isBlocked(scenes.occluders[k], sun) ? 0 : direct(sun, irradiance), whole_sh = 0,
                   factored = isBlocked(scenes.occluders[k], found.direction)
                                  ? 0
                                  : direct(found.direction, found.irradiance.x);
            for (std::size_t q = 0; q < half.size(); ++q) truth += truth_sky[q] * open[k][q];
            for (std::size_t s = 0; s < whole.size(); ++s)
                whole_sh += all[s] * coefficients[k][s], factored += soft[s] * coefficients[k][s];
            errors.all += (whole_sh - truth) * (whole_sh - truth);
            errors.factored += (factored - truth) * (factored - truth);
            errors.truth += truth * truth;
        }
    }
};

TEST(SunShading, FactoredIsNearerToBruteForceThanSh) {
    const SunScenes scenes;
    struct Row {
        const char* brdf;
        double all, factored;  // the golden figure, and a bound just above the golden figure
    };
    for (const Row& row : {Row{"lambert", 0.168, 0.095}, Row{"ggx:alpha=0.3,f0=0.9", 0.498, 0.095}}) {
        const RgbBrdf brdf = rgbBrdf(parseBrdf(row.brdf));
        Errors errors;
        for (const Vec3d d : fibonacciSphere(32)) {
            if (d.z < 0.25) continue;
            for (std::size_t v = 0; v < scenes.scenes.views.size(); v += 4)
                scenes.add(brdf, scenes.scenes.views[v], d, 5, errors);
        }
        const double all = std::sqrt(errors.all / errors.truth), factored = std::sqrt(errors.factored / errors.truth);
        std::printf("%s: all SH %.4f, factored %.4f\n", row.brdf, all, factored);
        EXPECT_GT(all, 0.8 * row.all) << row.brdf;
        EXPECT_LE(factored, row.factored) << row.brdf;
    }
}

}  // namespace
}  // namespace penumbra::test_sun_shading
