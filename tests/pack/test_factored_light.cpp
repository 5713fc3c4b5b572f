// Assets with suns and pictures of lights: what they hold, what they cost, and what their reader refuses.
#include <gtest/gtest.h>

#include <cmath>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "pack/pack_asset.h"
#include "tests/pack/changed_asset.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_factored_light {
namespace {

LightFile factoredLight() {
    LightFile light = synthetic::light(4, 0.3);
    light.factor = "hand-over";
    light.suns = {{{0.6, 0.8, 0}, {5, 4, 3}, 0.005}, {{0, 0, -1}, {1, 0, 1}, 0}};
    light.window = {1, 0.9, 0.8, 0.7};
    light.picture = {4, 2, std::vector<float>(24, 0.5f)};
    light.picture.pixels[5] = 65504;
    return light;
}

std::vector<std::byte> packedWith(const LightFile& light) { return packLibrary({}, std::span(&light, 1), "{}"); }

TEST(FactoredLight, TheAssetHoldsSunsWindowAndPicture) {
    const std::vector<std::byte> bytes = packedWith(factoredLight());
    const LightView light = openAsset(bytes).lights[0];
    ASSERT_EQ(light.suns.size(), 2u);
    EXPECT_EQ(light.suns[0].direction, (Vec3{0.6f, 0.8f, 0}));
    EXPECT_EQ(light.suns[0].irradiance, (Vec3{5, 4, 3}));
    EXPECT_EQ(light.suns[0].radius, 0.005f);
    ASSERT_EQ(light.window.size(), 4u);
    EXPECT_EQ(light.window[3], 0.7f);
    EXPECT_EQ(light.picture.width, 4);
    ASSERT_EQ(light.picture.texels.size(), 24u);
    EXPECT_EQ(halfToFloat(light.picture.texels[4]), 0.5f);
    EXPECT_EQ(halfToFloat(light.picture.texels[5]), 65504.0f);
    std::size_t listed = 0;
    for (const SizeOf& size : sectionSizes(openAsset(bytes), bytes.size()))
        if (size.section == "light pictures") listed = size.bytes;
    EXPECT_EQ(listed, 48u);
}

// A light that is not factored stays as it is, and so does one in which no sun was found and no picture asked for.
TEST(FactoredLight, OtherLightsKeepTheirBytes) {
    LightFile plain = factoredLight();
    plain.factor.clear(), plain.suns.clear(), plain.window.clear(), plain.picture = {};
    LightFile none = plain;
    none.factor = "hand-over", none.window = {1, 0.9, 0.8, 0.7};
    EXPECT_EQ(packedWith(plain), packedWith(none));
}

template <class Change>
std::string refusalAfter(const Change& change) {
    return refusalOf(packedWith(factoredLight()),
                     [&](fbs::Asset& asset) { change(*asset.mutable_lights()->GetMutableObject(0)); });
}

TEST(FactoredLight, WrongNumbersAreRefused) {
    const auto sun = [](flatbuffers::uoffset_t at, float value) {
        return refusalAfter([=](fbs::Light& light) { light.mutable_suns()->Mutate(at, value); });
    };
    EXPECT_EQ(sun(10, 0.5f), "accepted");
    EXPECT_EQ(sun(7, 0.5f), "x.pnb: lights[0].suns[1][0] is not a unit vector");
    EXPECT_EQ(sun(3, -1), "x.pnb: lights[0].suns[0] has a negative irradiance");
    for (const float bad : {-0.1f, 2.0f})
        EXPECT_EQ(sun(13, bad), "x.pnb: lights[0].suns[1] has a radius that is not in [0, 1.6)");
    for (const float bad : {NAN, INFINITY})
        for (const flatbuffers::uoffset_t at : {0u, 4u, 6u})
            EXPECT_EQ(sun(at, bad), "x.pnb: lights[0].suns has a number that is not finite");
    for (const float bad : {-0.1f, 1.1f})
        EXPECT_EQ(refusalAfter([=](fbs::Light& light) { light.mutable_window()->Mutate(1, bad); }),
                  "x.pnb: lights[0].window has a factor that is not in [0, 1]");
    for (const int half : {0x7c00, 0x7e00, 0xbc00, 0x8000})
        EXPECT_EQ(refusalAfter([=](fbs::Light& light) { light.mutable_picture()->Mutate(7, std::uint16_t(half)); }),
                  "x.pnb: lights[0].picture has a texel that is negative or not finite");
    EXPECT_EQ(refusalAfter([](fbs::Light& light) { light.mutate_picture_width(5); }),
              "x.pnb: lights[0].picture_width is odd");
    for (const int width : {2, 6, 4096})
        EXPECT_NE(refusalAfter([=](fbs::Light& light) {
                      light.mutate_picture_width(std::uint16_t(width));
                  }).find("x.pnb: lights[0].picture has 24 elements"),
                  std::string::npos);
    EXPECT_NE(refusalAfter([](fbs::Light& light) { light.mutate_picture_width(65534); }).find("picture_width is 65534"),
              std::string::npos);
}

TEST(FactoredLight, MoreThanEightSunsAreRefused) {
    LightFile light = factoredLight();
    light.suns.resize(9, light.suns[0]);
    const std::vector<std::byte> bytes = packedWith(light);
    EXPECT_THROW(openAsset(bytes), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_factored_light
