#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "formats/common/fp16.h"
#include "formats/image/image_file.h"
#include "player/frame/sky_picture.h"

namespace penumbra::test_sky_picture {
namespace {

float redTowards(const SkyPicture& sky, Vec3d direction) {
    double u, v;
    latLongCoordinates(direction, u, v);
    const int column = std::min(int(u * sky.width), sky.width - 1), row = std::min(int(v * sky.height), sky.height - 1);
    return halfToFloat(sky.texels[std::size_t(row * sky.width + column)][0]);
}

// L = 1 + 2 y goes from -1 to 3; what is below 0 shows as 0.
TEST(SkyPicture, ShAreSeenWhereTheyComeFrom) {
    std::array<float, 12> sh{};
    for (std::size_t c = 0; c < 3; ++c) {
        sh[c] = std::sqrt(4 * std::numbers::pi_v<float>);
        sh[3 + c] = -2 * std::sqrt(4 * std::numbers::pi_v<float> / 3);  // y_1,-1 = -sqrt(3/4pi) y
    }
    const SkyPicture sky = skyPicture({"slope", 2, sh});
    EXPECT_NEAR(redTowards(sky, {0.01, 1, 0}), 3, 0.01);
    EXPECT_EQ(redTowards(sky, {0.01, -1, 0}), 0);
    EXPECT_NEAR(redTowards(sky, {1, 0, 0}), 1, 0.05);  // half a texel beside the horizon
    EXPECT_TRUE(sky.suns.empty());
}

TEST(SkyPicture, ALightsOwnPictureComesWithItsSuns) {
    const std::array<float, 3> sh{};
    const std::array<std::uint16_t, 6> texels = {1, 2, 3, 4, 5, 6};
    const std::array<Sun, 1> suns = {Sun{{0, 1, 0}, {2, 2, 2}, 0.01f}};
    LightView light{"two texels", 1, sh};
    light.picture = {2, 1, texels};
    light.suns = suns;
    const SkyPicture sky = skyPicture(light);
    ASSERT_EQ(sky.texels.size(), 2u);
    EXPECT_EQ(sky.texels[1], (std::array<std::uint16_t, 4>{4, 5, 6, 0}));
    ASSERT_EQ(sky.suns.size(), 1u);
    EXPECT_EQ(sky.suns[0].irradiance.x, 2);
}

// A picture in 4096 columns becomes means of two by two; a small one stays as it is.
TEST(SkyPicture, APictureIsShownItself) {
    const auto mapOf = [](int width) {
        Image image{width, width / 2, {}, {}};
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                image.pixels.push_back({float(x % 2 + 2 * (y % 2)), x < width / 2 ? 1.0f : 3.0f, 0.25f});
        return makeEnvironmentMap(std::move(image), "latlong", "a picture");
    };
    const EnvironmentMap small = mapOf(8);
    const SkyPicture same = skyPicture(small);
    ASSERT_EQ(same.width, 8);
    for (std::size_t i = 0; i < same.texels.size(); ++i) {
        EXPECT_EQ(halfToFloat(same.texels[i][0]), small.image.pixels[i].x) << i;
        EXPECT_EQ(halfToFloat(same.texels[i][1]), small.image.pixels[i].y) << i;
        EXPECT_EQ(halfToFloat(same.texels[i][2]), small.image.pixels[i].z) << i;
    }
    const SkyPicture means = skyPicture(mapOf(4096));
    ASSERT_EQ(means.width, 2048);
    ASSERT_EQ(means.texels.size(), 2048u * 1024u);
    for (const std::size_t i : std::array<std::size_t, 3>{0, 1023, 2048 * 1023 + 2047}) {
        EXPECT_EQ(halfToFloat(means.texels[i][0]), 1.5f) << i;
        EXPECT_EQ(halfToFloat(means.texels[i][1]), i % 2048 < 1024 ? 1.0f : 3.0f) << i;
    }
}

// The center of an angular map looks along +x.
TEST(SkyPicture, OtherShapesAreUnfolded) {
    Image image{64, 64, {}, {}};
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) image.pixels.push_back({std::hypot(x - 31.5f, y - 31.5f) < 8 ? 2.0f : 0.5f, 0, 0});
    const SkyPicture sky = skyPicture(makeEnvironmentMap(std::move(image), "angular", "a probe"));
    EXPECT_NEAR(redTowards(sky, {1, 0.01, 0}), 2, 0.01);
    EXPECT_NEAR(redTowards(sky, {0, 1, 0.01}), 0.5, 0.01);
}

}  // namespace
}  // namespace penumbra::test_sky_picture
