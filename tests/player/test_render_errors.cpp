// Tests what cannot be drawn (unknown names, missing data, limits of OpenGL), and how names are found.
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "player/render/render_offscreen.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_render_errors {
namespace {

using player_test::SyntheticAsset;

RenderOptions smallPicture() {
    RenderOptions options;
    options.width = options.height = 96;
    options.clip = "swing";
    options.frame = 1;
    return options;
}

std::string messageOf(const RenderOptions& options, const AssetView& asset, const AssetView* truth) {
    try {
        renderOffscreen(options, asset, truth, 1);
    } catch (const UsageError& error) {
        return std::string("usage: ") + error.what();
    } catch (const InvalidInput& error) {
        return std::string("input: ") + error.what();
    }
    return "";
}

TEST(Render, UnknownNamesAreUsageErrorsThatListTheKnownOnes) {
    const SyntheticAsset data;
    RenderOptions options = smallPicture();
    options.clip = "walk";
    EXPECT_EQ(messageOf(options, data.asset, nullptr), "usage: clip: the asset has no \"walk\"; it has swing, still");
    options = smallPicture();
    options.brdf = "gold";
    EXPECT_EQ(messageOf(options, data.asset, nullptr),
              "usage: brdf: the asset has no \"gold\"; it has lambert, ggx, tinted");
    options = smallPicture();
    options.clip = "s";
    EXPECT_EQ(messageOf(options, data.asset, nullptr),
              "usage: clip: the asset has more than one \"s\"; it has swing, still");
    options.clip = "sw";
    EXPECT_EQ(messageOf(options, data.asset, nullptr), "");
    options = smallPicture();
    options.light = "moon";
    EXPECT_EQ(messageOf(options, data.asset, nullptr), "usage: light: the asset has no \"moon\"; it has sky, even");
    options = smallPicture();
    options.frame = 3;
    EXPECT_EQ(messageOf(options, data.asset, nullptr), "usage: frame: must be 0..2 for clip \"swing\", not 3");
    options = smallPicture();
    options.camera = "roll=3";
    EXPECT_EQ(messageOf(options, data.asset, nullptr).substr(0, 14), "usage: camera:");
}

TEST(Render, MaterialsOfSlotsAreNamed) {
    SyntheticAsset data({.slots = 3});
    RenderOptions options = smallPicture();
    options.brdf = "ggx";
    options.slots = {"part0=lam", "part2=tinted"};
    const Shot shot = resolveShot(options, data.asset, nullptr);
    EXPECT_EQ(shot.material_of_slot, (std::vector<std::size_t>{0, 1, 2}));
    options.brdf = "";
    options.slots = {};
    EXPECT_EQ(resolveShot(options, data.asset, nullptr).material_of_slot, (std::vector<std::size_t>{0, 1, 2}));
    options.slots = {"part=ggx", "part1=lambert"};
    EXPECT_EQ(resolveShot(options, data.asset, nullptr).material_of_slot, (std::vector<std::size_t>{1, 0, 1}));
    const std::pair<const char*, const char*> wrong[] = {
        {"part0", "usage: slot: must be SLOT=MATERIAL, not \"part0\""},
        {"head=ggx", "usage: slot: no slot \"head\"; there are part0, part1, part2"},
        {"part1=gold", "usage: slot: the asset has no \"gold\"; it has lambert, ggx, tinted"}};
    for (const auto& [text, message] : wrong) {
        options.slots = {text};
        EXPECT_EQ(messageOf(options, data.asset, nullptr), message);
    }
    const SyntheticAsset plain;
    options.slots = {"part0=ggx"};
    EXPECT_NE(messageOf(options, plain.asset, nullptr).find("usage: slot: the asset's mesh is one part"),
              std::string::npos);
}

TEST(Render, WhatAMaterialOrLightLacksIsSaid) {
    SyntheticAsset data({.slots = 2});
    data.asset.materials[1].operators = {};
    data.asset.lights[1].lobes = {};
    RenderOptions options = smallPicture();
    options.shading.reflectance = Reflectance::kOperators;
    EXPECT_EQ(messageOf(options, data.asset, nullptr),
              "usage: reflectance: the asset's material \"ggx\" has no operators; penumbra-fit brdf makes them");
    options.brdf = "tinted";
    EXPECT_EQ(messageOf(options, data.asset, nullptr), "") << "a material that is not on need not have them";
    options.shading.light_form = LightForm::kLobes;
    EXPECT_EQ(messageOf(options, data.asset, nullptr), "");
    options.light = "even";
    EXPECT_EQ(messageOf(options, data.asset, nullptr),
              "usage: light_form: the asset's light \"even\" has no lobes; penumbra-fit light makes them");
    options = smallPicture();
    options.light_rotation = "yaw=1000";
    EXPECT_EQ(messageOf(options, data.asset, nullptr),
              "usage: light_rotation: light rotation yaw must be a number from -360 to 360, not '1000'");
}

TEST(Render, WhatIsMissingIsSaid) {
    SyntheticAsset data;
    RenderOptions options = smallPicture();
    options.channel = Channel::kError;
    EXPECT_NE(messageOf(options, data.asset, nullptr).find("usage: truth: the channels error"), std::string::npos);
    data.truth.animation.clips[0].name = "walk";
    EXPECT_EQ(messageOf(options, data.asset, &data.truth), "input: asset: has no clip \"swing\"");
    data.truth.animation.clips[0] = {"swing", 0, 1, false};
    EXPECT_NE(messageOf(options, data.asset, &data.truth).find("so none of number 1"), std::string::npos);
    data.truth.animation.clips[0] = {"swing", 1, 3, false};  // another time
    EXPECT_NE(messageOf(options, data.asset, &data.truth).find("sampled differently"), std::string::npos);
    data.truth.has_truth = false;
    EXPECT_NE(messageOf(options, data.asset, &data.truth).find("no baked frames"), std::string::npos);
    options = smallPicture();
    data.asset.materials.clear();
    EXPECT_NE(messageOf(options, data.asset, nullptr).find("holds no brdf"), std::string::npos);
    data.asset.has_model = false;
    EXPECT_NE(messageOf(options, data.asset, nullptr).find("holds no model"), std::string::npos);
}

TEST(Render, TooManySamplesOrPixelsAreUnsupported) {
    const SyntheticAsset data;
    RenderOptions options = smallPicture();
    options.backend = GlBackend::kOsMesa;
    options.samples = 8;  // llvmpipe has 4
    EXPECT_THROW(renderOffscreen(options, data.asset, nullptr, 1), Unsupported);
}

}  // namespace
}  // namespace penumbra::test_render_errors
