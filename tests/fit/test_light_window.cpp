#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fit/light/fit_light.h"
#include "fit/light/light_lobes.h"
#include "sh/light/sharpest_window.h"
#include "sh/quadrature.h"
#include "sh/zonal.h"
#include "tests/fit/pixel_sun.h"
#include "tests/sh/golden.h"

namespace penumbra::test_light_window {
namespace {

using std::numbers::pi;

std::vector<double> deltaLight(int order) {
    std::vector<double> sh(3 * std::size_t(coefficientCount(order))), y(sh.size() / 3);
    evalBasis(order, normalized(Vec3d{1, 2, -2}), y);
    for (std::size_t i = 0; i < sh.size(); ++i) sh[i] = y[i / 3];
    return sh;
}

// The golden file has the windows of orders 3 to 6. All are non-negative kernels that touch 0 (measured: -1e-16 of the
// peak).
TEST(LightWindow, SharpestWindowMatchesGoldenAndIsNotNegative) {
    const nlohmann::json golden = readGolden("light.json").at("windows");
    for (int order = 1; order <= kMaxOrder; ++order) {
        const std::span<const double> w = sharpestWindow(order);
        if (order >= 3 && order <= 6)
            expectNear(w, doubles(golden.at(std::to_string(order) + " sharpest nonneg")), 1e-12);
        double least = 1;
        for (int i = 0; i <= 20000; ++i) {
            const double x = i / 10000.0 - 1;
            double before = 1, p = x, kernel = 1;
            for (int l = 1; l < order; ++l) {
                kernel += (2 * l + 1) * w[std::size_t(l)] * p;
                const double next = ((2 * l + 1) * x * p - l * before) / (l + 1);
                before = p;
                p = next;
            }
            least = std::min(least, kernel);
        }
        EXPECT_GT(least, -1e-12) << order;
    }
}

// The kernel of a delta at order 4 is lowest at -1/4 of its peak. The peak is 16 times the mean, so that is -4 times
// the mean. The second light has one pole.
TEST(LightWindow, LeastRadianceMatchesClosedForm) {
    EXPECT_NEAR(leastRadiance(4, deltaLight(4)), -4.0, 1e-4);
    std::vector<double> sh(12, 0.0);
    for (std::size_t c = 0; c < 3; ++c) sh[c] = 1, sh[6 + c] = 0.8;  // 1 + sqrt 3 0.8 z
    EXPECT_NEAR(leastRadiance(2, sh), 1 - 0.8 * std::sqrt(3.0), 1e-6);
}

TEST(LightWindow, NoneAndLambdaDoWhatTheySay) {
    std::vector<double> sh = deltaLight(4);
    const std::vector<double> before = sh;
    EXPECT_FALSE(windowLight(4, parseWindow("none"), sh).any());
    EXPECT_EQ(sh, before);
    windowLight(4, parseWindow("0.1"), sh);
    for (std::size_t i = 0; i < sh.size(); ++i) {
        const int l = bandOfIndex(int(i / 3));
        EXPECT_NEAR(sh[i], before[i] / (1 + 0.1 * l * l * (l + 1) * (l + 1)), 1e-15);
    }
    for (const char* bad : {"", "some", "-1", "1e4", "nan"})
        EXPECT_THROW(parseWindow(bad), std::invalid_argument) << bad;
}

TEST(LightWindow, AutoLeavesPicturesWithoutAHotPixel) {
    Image image{128, 64, std::vector<Vec3>(128 * 64, Vec3{1, 1, 1}), {}};
    for (int y = 20; y < 23; ++y)
        for (int x = 40; x < 43; ++x) image.pixels[std::size_t(128 * y + x)] = {1e4f, 1e4f, 1e4f};
    const EnvironmentMap map = makeEnvironmentMap(image, "", "sun.exr");
    EXPECT_EQ(findHotPixel(map).share, 0);
    LightFile light = fitLight(map, "sun.exr", 4, 1);
    const std::vector<double> before = light.sh;
    const WindowReport report = windowFit({}, findHotPixel(map), light);
    EXPECT_FALSE(report.any());
    EXPECT_LT(report.least_after, -1);  // reported but not mended
    EXPECT_EQ(light.sh, before);
    EXPECT_GE(windowFit({WindowChoice::Mode::kAlways, 0}, {}, light).least_after, -0.01);
    EXPECT_EQ(findHotPixel(pixelSun(1.2f, {1, 1, 1})).share, 0);  // bright, but not most of the light
    EXPECT_EQ(findHotPixel(pixelSun(0, {0, 0, 0})).share, 0);
    const HotPixel hot = findHotPixel(pixelSun(1e5f, {1, 1, 1}));
    EXPECT_EQ(hot.x, 17);
    EXPECT_EQ(hot.y, 21);
    EXPECT_NEAR(hot.share, 0.94, 0.01);
}

// The residual with a window follows from the residual without it and from what the window took. A hemisphere compares
// it with the definition.
TEST(LightWindow, ResidualIsThatOfTheWindowedLight) {
    const std::vector<AnalyticLight> lights = parseLights("disc:angle=90");
    LightFile light = fitLight(lights, "half a sky", 5);
    windowFit({WindowChoice::Mode::kLambda, 0.05}, {}, light);
    std::vector<double> y(25);
    double left = 0;
    for (const auto& [d, weight] : gaussHemisphere(40, 40))
        for (double side : {1.0, -1.0}) {
            const Vec3d at{d.x, side * d.z, d.y};
            evalBasis(5, at, y);
            double sum = side < 0 ? 0 : -1;
            for (std::size_t i = 0; i < 25; ++i) sum += y[i] * light.sh[3 * i];
            left += weight * sum * sum;
        }
    EXPECT_NEAR(light.residual, std::sqrt(left / (2 * pi)), 1e-9);
    EXPECT_EQ(light.window.size(), 5u);
}

}  // namespace
}  // namespace penumbra::test_light_window
