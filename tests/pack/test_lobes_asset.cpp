// Lobes of materials in an asset.
#include <gtest/gtest.h>

#include <cmath>

#include "asset_generated.h"
#include "formats/asset/asset_file.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "tests/pack/changed_asset.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_lobes_asset {
namespace {

std::vector<std::byte> packedWith(std::vector<BrdfLobe> lobes, double error = 0) {
    BrdfFile brdf = synthetic::lambert();
    brdf.lobes = std::move(lobes);
    brdf.lobe_error = error;
    const std::vector<BrdfFile> brdfs = {brdf};
    return packLibrary(brdfs, {}, "{}");
}

const std::vector<BrdfLobe>& twoLobes() {
    static const std::vector<BrdfLobe> lobes = {lobeOf(parseBrdf("lambert:color=0.5/0.25/0.1")),
                                                lobeOf(parseBrdf("ashikhmin-shirley"))};
    return lobes;
}

TEST(LobesAsset, HoldsTheLobes) {
    const std::vector<std::byte> bytes = packedWith(twoLobes(), 0.125);
    const AssetView asset = openAsset(bytes);
    const MaterialView& material = asset.materials.at(0);
    EXPECT_EQ(std::vector(material.lobes.begin(), material.lobes.end()), twoLobes());
    EXPECT_EQ(material.lobe_error, 0.125f);
}

// A lobe is 32 bytes, which are listed among the materials.
TEST(LobesAsset, LobesAreListedByTheirBytes) {
    const auto bytesOfMaterials = [](const std::vector<std::byte>& bytes) {
        for (const SizeOf& size : sectionSizes(openAsset(bytes), bytes.size()))
            if (size.section == "materials") return size.bytes;
        return std::size_t(0);
    };
    EXPECT_EQ(
        bytesOfMaterials(packedWith(std::vector<BrdfLobe>(3))) - bytesOfMaterials(packedWith(std::vector<BrdfLobe>(1))),
        64u);
}

TEST(LobesAsset, WrongLobesAreRefused) {
    const std::string wrong =
        "x.pnb: materials[0].lobes[1] has an unknown model, or a parameter or a colour out of range";
    const auto refusal = [](const auto& change) {
        std::vector<BrdfLobe> lobes = twoLobes();
        change(lobes[1]);
        return refusalOf(packedWith(lobes));
    };
    EXPECT_EQ(refusal([](BrdfLobe&) {}), "accepted");
    EXPECT_EQ(refusal([](BrdfLobe& lobe) { lobe.model = BrdfModel(200); }), wrong);
    for (const float bad : {NAN, INFINITY, -1.0f, 1e6f})
        EXPECT_EQ(refusal([bad](BrdfLobe& lobe) { lobe.parameters[1] = bad; }), wrong) << bad;
    for (const float bad : {NAN, INFINITY, -1.0f})
        EXPECT_EQ(refusal([bad](BrdfLobe& lobe) { lobe.color.z = bad; }), wrong) << bad;
    EXPECT_EQ(refusalOf(packedWith({})), "x.pnb: materials[0].lobes is 0, allowed are 1..4");
    EXPECT_EQ(refusalOf(packedWith(std::vector<BrdfLobe>(5))), "x.pnb: materials[0].lobes is 5, allowed are 1..4");
    for (const double bad : {double(NAN), -1.0})
        EXPECT_EQ(refusalOf(packedWith(twoLobes(), bad)), "x.pnb: materials[0].lobe_error is not 0 or more") << bad;
}

TEST(LobesAsset, RejectsEveryTruncation) { expectTruncationsRefused(packedWith(twoLobes())); }

}  // namespace
}  // namespace penumbra::test_lobes_asset
