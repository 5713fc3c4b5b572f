// Materials with steps of a parameter in an asset: what is written is read back, and broken ones are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "pack/sections/asset_writer.h"
#include "sh/reflectance.h"
#include "tests/pack/changed_asset.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_stepped_asset {
namespace {

// Steps of ggx alpha whose slices are multiples of a Lambertian material's, in a colour or in three of their own.
BrdfFile stepped(bool own_channels = false) {
    BrdfFile brdf = synthetic::lambert({1, 0.5, 0.25});
    brdf.name = "stepped";
    brdf.lobes = {lobeOf(parseBrdf("ggx:alpha=0.2,color=1/0.5/0.25"))};
    brdf.steps = BrdfSteps{0, {0.1, 0.2, 0.4}, {}, 0.01};
    for (const double scale : {0.5, 1.0, 2.0})
        for (std::size_t i = 0; i < brdf.slices.size(); ++i)
            brdf.steps->slices.push_back((own_channels && scale == 2 && i % 3 == 0 ? 0.9 : 1) * scale * brdf.slices[i]);
    return brdf;
}

std::vector<std::byte> packed(const std::vector<BrdfFile>& brdfs) {
    return packAsset(synthetic::tubeModel({}), brdfs, std::vector<LightFile>{synthetic::light(4, 0.3)}, {}, "{}", 1)
        .bytes;
}

TEST(SteppedAsset, IsReadBack) {
    for (const bool own_channels : {false, true}) {
        const BrdfFile file = stepped(own_channels);
        const std::vector<std::byte> one = packed({file});
        const AssetView asset = openAsset(one);
        const MaterialView& material = asset.materials[0];
        EXPECT_EQ(material.channels, own_channels ? 3 : 1) << "a step with a colour of its own needs three channels";
        EXPECT_EQ(std::vector<double>(material.steps.begin(), material.steps.end()), file.steps->values);
        EXPECT_FLOAT_EQ(material.step_error, 0.01f);
        EXPECT_EQ(material.step_parameter, 0u);
        const std::size_t size = material.slices.size();
        ASSERT_EQ(material.step_slices.size(), 3 * size);
        for (std::size_t i = 0; i < size; ++i) {
            EXPECT_EQ(material.step_slices[size + i], material.slices[i]) << "the step of the start";
            EXPECT_EQ(material.step_slices[i], 0.5f * material.slices[i]);
        }
        EXPECT_LT(material.stored_step_slices.size(), material.step_slices.size()) << "in the most compact form";
    }
}

TEST(SteppedAsset, BrokenOnesAreRefused) {
    BrdfFile ay = stepped();
    ay.lobes = {lobeOf(parseBrdf("ward:ax=0.5,ay=0.2"))};
    ay.steps->parameter = 1;
    const std::vector<std::byte> bytes = packed({ay});
    const auto expect = [&](const char* words, const std::function<void(fbs::Material&)>& change) {
        const std::string said =
            refusalOf(bytes, [&](fbs::Asset& a) { change(*a.mutable_materials()->GetMutableObject(0)); });
        EXPECT_NE(said.find(words), std::string::npos) << said;
    };
    expect("materials[0].steps[1]", [](fbs::Material& m) { m.mutable_steps()->Mutate(1, 0.1); });
    expect("materials[0].steps[0]", [](fbs::Material& m) { m.mutable_steps()->Mutate(0, 0); });
    expect("materials[0].steps[2]", [](fbs::Material& m) { m.mutable_steps()->Mutate(2, NAN); });
    expect("materials[0].step_slices", [](fbs::Material& m) { m.mutable_step_slices()->Mutate(3, INFINITY); });
    expect("materials[0].step_parameter", [](fbs::Material& m) { m.mutate_step_parameter(2); });
    expect("materials[0].step_error", [](fbs::Material& m) { m.mutate_step_error(-1); });
    const auto setLobe = [](fbs::Material& m, float ay_now) {
        const_cast<fbs::BrdfLobe*>(m.mutable_lobes()->Get(0))->mutable_parameters()->Mutate(1, ay_now);
    };
    expect("do not enclose", [&](fbs::Material& m) { setLobe(m, 0.5f); });
}

// Two of three lobes follow the steps, and the surface glows.
TEST(SteppedAsset, OfSeveralLobesIsReadBackAndBrokenOnesAreRefused) {
    BrdfFile file = stepped();
    file.lobes = {lobeOf(parseBrdf("principled-diffuse")), lobeOf(parseBrdf("ggx-f0:roughness=0.2")),
                  lobeOf(parseBrdf("ggx-f90:roughness=0.2"))};
    file.steps->lobes = 0b110;
    file.emission = {4, 2, 0};
    const std::vector<std::byte> bytes = packed({file}), plain = packed({stepped()});
    EXPECT_EQ(openAsset(bytes).materials[0].step_lobes, 0b110);
    EXPECT_EQ(openAsset(bytes).materials[0].emission, (Vec3{4, 2, 0}));
    EXPECT_EQ(openAsset(plain).materials[0].step_lobes, 1);
    EXPECT_EQ(openAsset(plain).materials[0].emission, Vec3{});
    const auto expect = [&](const char* words, const std::function<void(fbs::Material&)>& change) {
        const std::string said =
            refusalOf(bytes, [&](fbs::Asset& a) { change(*a.mutable_materials()->GetMutableObject(0)); });
        EXPECT_NE(said.find(words), std::string::npos) << said;
    };
    expect("materials[0].step_lobes names lobes", [](fbs::Material& m) { m.mutate_step_lobes(8); });
    expect("materials[0].step_lobes have no parameter in common", [](fbs::Material& m) { m.mutate_step_lobes(7); });
    expect("materials[0].emission is not 0 or more", [](fbs::Material& m) { m.mutable_emission()->Mutate(0, NAN); });
    expectTruncationsRefused(bytes, 97);
}

TEST(SteppedAsset, RejectsEveryTruncation) { expectTruncationsRefused(packed({stepped()}), 97); }

}  // namespace
}  // namespace penumbra::test_stepped_asset
