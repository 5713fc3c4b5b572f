#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "sh/brdf/spectrum.h"

namespace penumbra::test_spectrum {
namespace {

std::vector<double> wavelengths(double first, double step, int n) {
    std::vector<double> w;
    for (int i = 0; i < n; ++i) w.push_back(first + step * i);
    return w;
}

Vec3d colourOf(const std::vector<double>& w, double (*reflectance)(double)) {
    const std::vector<Vec3d> weights = rec709Weights(w);
    Vec3d rgb;
    for (std::size_t k = 0; k < w.size(); ++k) rgb += weights[k] * reflectance(w[k]);
    return rgb;
}

TEST(Spectrum, AFlatReflectorIsGreyForAnySampling) {
    for (const auto& w : {wavelengths(400, 10, 31), wavelengths(380, 5, 81), wavelengths(450, 100, 3)}) {
        const Vec3d grey = colourOf(w, [](double) { return 0.5; });
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(grey[c], 0.5, 1e-12);
    }
}

// Bands of the spectrum have the colours that they are named after, and the bands add up to white.
TEST(Spectrum, BandsHaveTheirColours) {
    const auto w = wavelengths(400, 10, 31);
    const Vec3d blue = colourOf(w, [](double x) { return x < 490 ? 1.0 : 0.0; });
    const Vec3d green = colourOf(w, [](double x) { return x >= 490 && x < 590 ? 1.0 : 0.0; });
    const Vec3d red = colourOf(w, [](double x) { return x >= 590 ? 1.0 : 0.0; });
    EXPECT_GT(blue.z, 10 * std::max(blue.x, blue.y));
    EXPECT_GT(green.y, 2 * std::max(green.x, green.z));
    EXPECT_GT(red.x, 5 * std::max(red.y, red.z));
    const Vec3d white = blue + green + red;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 1e-12);
}

// Values between samples are interpolated linearly, so a spectrum sampled twice as densely gives nearly the same
// colour. Measured 4e-4.
TEST(Spectrum, SmoothSpectraDoNotDependOnTheSampling) {
    const auto smooth = [](double x) { return 0.5 + 0.4 * std::sin((x - 400) / 60); };
    const Vec3d coarse = colourOf(wavelengths(400, 10, 31), smooth), fine = colourOf(wavelengths(400, 5, 61), smooth);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(coarse[c], fine[c], 2e-3);
}

// Before the channels are normalised to exactly 1, D65 through the fitted functions is Rec.709's white to 1%. The share
// of luminance of each channel is therefore that of Rec.709. The luminance of a spectral line is 0.2126 r + 0.7152 g +
// 0.0722 b and positive.
TEST(Spectrum, LuminanceOfGreenLightIsPositiveThoughItLiesOutsideRec709) {
    const Vec3d line = colourOf(wavelengths(400, 5, 61), [](double x) { return x == 520 ? 1.0 : 0.0; });
    EXPECT_LT(line.x, 0);
    EXPECT_GT(0.2126 * line.x + 0.7152 * line.y + 0.0722 * line.z, 0);
}

}  // namespace
}  // namespace penumbra::test_spectrum
