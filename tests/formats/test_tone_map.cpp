#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "formats/image/tone_map.h"

namespace penumbra::test_tone_map {
namespace {

TEST(ToneMap, KeepsBlackAndEndsAtWhite) {
    for (const auto& [word, tone] : kToneWords) {
        EXPECT_EQ(toneMapped({0, 0, 0}, tone), (Vec3{0, 0, 0})) << word;
        EXPECT_EQ(toneMapped({-1, 0, 0}, tone).x, 0) << word;
        float before = 0;
        for (float c = 0.01f; c < 100; c *= 1.1f) {
            const float shown = toneMapped(Vec3{c, c, c}, tone).y;
            EXPECT_GE(shown, before) << word << ' ' << c;
            before = shown;
        }
        EXPECT_TRUE(tone == ToneMap::kOff || (before > 0.98f && before <= 1)) << word << ' ' << before;
    }
    EXPECT_FLOAT_EQ(toneMapped({0, 3, 0}, ToneMap::kReinhard).y, 0.75f);
    // Narkowicz's curve at 0.18 and at 1, from its formula in double precision.
    EXPECT_NEAR(toneMapped({0.18f, 1, 0}, ToneMap::kFilmic).x, 0.266899, 1e-5);
    EXPECT_NEAR(toneMapped({0.18f, 1, 0}, ToneMap::kFilmic).y, 0.803797, 1e-5);
}

// Half a pixel of a bright colour is half of what the colour becomes.
TEST(ToneMap, TakesTheColourWithoutItsAlpha) {
    const Image image{2, 1, {{2, 2, 2}, {1, 1, 1}}, {1, 0.5f}};
    const Image mapped = toneMapped(image, 1.5f, ToneMap::kReinhard);
    EXPECT_FLOAT_EQ(mapped.pixels[0].x, 0.75f);
    EXPECT_FLOAT_EQ(mapped.pixels[1].x, 0.375f);
    const Image nothing = toneMapped(Image{1, 1, {{0, 0, 0}}, {0}}, 1, ToneMap::kFilmic);
    EXPECT_EQ(nothing.pixels[0], (Vec3{0, 0, 0}));
}

}  // namespace
}  // namespace penumbra::test_tone_map
