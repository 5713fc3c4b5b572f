// Live materials and membranes in an asset: what is written is read back, and broken ones are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "pack/sections/asset_writer.h"
#include "tests/pack/changed_asset.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_live_asset {
namespace {

BrdfFile live(const char* text) {
    BrdfFile brdf;
    brdf.name = text;
    brdf.slice_order = brdf.view_order = 1;
    brdf.even_index = {0};
    brdf.lobes = {lobeOf(parseBrdf(text))};
    return brdf;
}

BrdfFile membrane() {
    BrdfFile brdf = synthetic::lambert();
    brdf.name = "membrane";
    brdf.lobes = {lobeOf({})};
    brdf.membrane = Membrane{{0.5f, 0.25f, 0}, {0.25f, 0.5f, 1}, true};
    return brdf;
}

std::vector<std::byte> packed(const std::vector<BrdfFile>& brdfs) {
    return packAsset(synthetic::clothModel(), brdfs, std::vector<LightFile>{synthetic::light(4, 0.3)}, {}, "{}", 1)
        .bytes;
}

TEST(LiveAsset, IsReadBack) {
    const std::vector<std::byte> bytes =
        packed({live("phong-live:exponent=20,color=0.5/1/0.25"), live("ggx-live:alpha=0.2"), membrane()});
    const AssetView asset = openAsset(bytes);
    const MaterialView &phong = asset.materials[0], &cloth = asset.materials[2];
    EXPECT_TRUE(phong.isLive());
    EXPECT_EQ(phong.lobes[0].model, BrdfModel::kPhongLive);
    EXPECT_EQ(phong.lobes[0].parameters[0], 20);
    EXPECT_EQ(phong.color, (Vec3{0.5f, 1, 0.25f}));
    EXPECT_EQ(phong.lobes[0].color, (Vec3{0.5f, 1, 0.25f}));
    EXPECT_TRUE(asset.materials[1].isLive());
    EXPECT_FALSE(cloth.isLive());
    EXPECT_EQ(*cloth.membrane, (Membrane{{0.5f, 0.25f, 0}, {0.25f, 0.5f, 1}, true}));
}

TEST(LiveAsset, BrokenOnesAreRefused) {
    const std::vector<std::byte> bytes = packed({membrane(), live("phong-live")});
    const auto expect = [&](const char* words, const std::function<void(fbs::Asset&)>& change) {
        const std::string said = refusalOf(bytes, change);
        EXPECT_NE(said.find(words), std::string::npos) << said;
    };
    const auto material = [](fbs::Asset& a, unsigned i) { return a.mutable_materials()->GetMutableObject(i); };
    expect("materials[0].membrane", [&](fbs::Asset& a) { material(a, 0)->mutable_membrane()->Mutate(0, -1); });
    expect("materials[0].membrane", [&](fbs::Asset& a) { material(a, 0)->mutable_membrane()->Mutate(4, 0.9f); });
    expect("materials[0].membrane", [&](fbs::Asset& a) { material(a, 0)->mutable_membrane()->Mutate(2, NAN); });
    expect("materials[1].lobes[0]", [&](fbs::Asset& a) {
        auto* lobes = material(a, 1)->mutable_lobes();
        const_cast<fbs::BrdfLobe*>(lobes->Get(0))->mutable_parameters()->Mutate(0, -1);
    });
    expect("materials[1].slices is missing", [&](fbs::Asset& a) {
        const_cast<fbs::BrdfLobe*>(material(a, 1)->mutable_lobes()->Get(0))->mutate_model(2);
    });
    expect("materials[1].channels", [&](fbs::Asset& a) { material(a, 1)->mutate_channels(3); });
}

TEST(LiveAsset, RejectsEveryTruncation) { expectTruncationsRefused(packed({membrane(), live("ggx-live")}), 97); }

}  // namespace
}  // namespace penumbra::test_live_asset
