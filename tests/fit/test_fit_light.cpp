#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "fit/light/fit_light.h"
#include "sh/sh_basis.h"
#include "sh/zonal.h"

namespace penumbra::test_fit_light {
namespace {

using std::numbers::pi;

LightFile fitLight(Image image, const std::string& name, int order) {
    return fitLight(makeEnvironmentMap(std::move(image), "latlong", name), name, order, 2);
}

Image latLong(int height, const std::function<Vec3(Vec3d)>& radiance) {
    Image image;
    image.width = 2 * height;
    image.height = height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < image.width; ++x)
            image.pixels.push_back(radiance(latLongDirection((x + 0.5) / image.width, (y + 0.5) / height)));
    return image;
}

// With 8 nodes in a row of 45 degrees, 2e-10 of band 7 is left. Rows of real pictures are exact to rounding.
TEST(FitLight, UniformPictureHasBandZeroOnly) {
    for (int height : {4, 5, 64}) {
        const LightFile light = fitLight(latLong(height, [](Vec3d) { return Vec3{1, 2, 0.5f}; }), "uniform.exr", 8);
        EXPECT_NEAR(light.sh[0], std::sqrt(4 * pi), 1e-12);
        EXPECT_NEAR(light.sh[1], 2 * std::sqrt(4 * pi), 1e-12);
        EXPECT_NEAR(light.sh[2], 0.5 * std::sqrt(4 * pi), 1e-12);
        for (std::size_t i = 3; i < light.sh.size(); ++i) EXPECT_NEAR(light.sh[i], 0, 1e-9) << i << " at " << height;
        EXPECT_LT(light.residual, 1e-6);
    }
}

// A function of the basis comes back. The mean over pixels of h = pi/128 takes l (l+1) h^2 / 24 = 5e-4 of band 4. What
// varies within pixels is l (l+1) h^2 / 12 of the energy, a residual of 0.03.
TEST(FitLight, BandLimitedPictureComesBack) {
    std::vector<double> y(25);
    const auto sum = [&y](Vec3d d, int salt) {
        evalBasis(5, d, y);
        double value = 0;
        for (std::size_t i = 0; i < y.size(); ++i) value += std::sin(double(i) * 3 + salt) * y[i];
        return float(value);
    };
    const Image image = latLong(128, [&](Vec3d d) { return Vec3{sum(d, 0) + 4, sum(d, 1) + 4, sum(d, 2) + 4}; });
    const LightFile light = fitLight(image, "basis.exr", 5);
    for (std::size_t i = 0; i < 25; ++i)
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(light.sh[3 * i + std::size_t(channel)],
                        std::sin(double(i) * 3 + channel) + (i == 0 ? 4 * std::sqrt(4 * pi) : 0), 6e-4);
    EXPECT_LT(light.residual, 0.03);
}

// The upper half is bright: 1 above y = 0 is the zonal function about +y with the z_l of a hemisphere.
TEST(FitLight, HalfSkyMatchesClosedForm) {
    const LightFile light = fitLight(latLong(8,
                                             [](Vec3d d) {
                                                 return d.y > 0 ? Vec3{1, 1, 1} : Vec3{};
                                             }),
                                     "sky.exr", 6);
    std::vector<double> zonal(6), expected(36);
    belowPlaneZonal(0, zonal);
    rotateZonal(zonal, {0, -1, 0}, expected);
    for (std::size_t i = 0; i < 36; ++i) EXPECT_NEAR(light.sh[3 * i], expected[i], 1e-12) << i;
    // |SH|^2 of the hemisphere is the sum of z_l^2, and |L|^2 is 2pi.
    double kept = 0;
    for (double z : zonal) kept += z * z;
    EXPECT_NEAR(light.residual, std::sqrt(1 - kept / (2 * pi)), 1e-7);
}

// One pixel far from the poles and the seams is bright. The SH are those of a small patch in its direction.
TEST(FitLight, PixelIsWhereTheConventionPutsIt) {
    Image image = latLong(64, [](Vec3d) { return Vec3{}; });
    const int x = 97, y = 20;
    image.pixels[std::size_t(y * 128 + x)] = {1000, 0, 0};
    const LightFile light = fitLight(image, "pixel.exr", 4);
    const double solid_angle = 2 * pi / 128 * (std::cos(pi * y / 64) - std::cos(pi * (y + 1) / 64));
    std::vector<double> basis(16);
    evalBasis(4, latLongDirection((x + 0.5) / 128, (y + 0.5) / 64), basis);
    for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(light.sh[3 * i], 1000 * solid_angle * basis[i], 5e-3) << i;
    EXPECT_GT(light.residual, 0.9);
}

TEST(FitLight, BlackPictureIsBlack) {
    const LightFile light = fitLight(latLong(4, [](Vec3d) { return Vec3{}; }), "black.exr", 4);
    for (double value : light.sh) EXPECT_EQ(value, 0);
    EXPECT_EQ(light.residual, 0);
}

}  // namespace
}  // namespace penumbra::test_fit_light
