// Assets with sphere blockers: what they hold, what they cost, and what their reader refuses.
#include <gtest/gtest.h>

#include <cmath>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "tests/pack/changed_asset.h"
#include "tests/synthetic_model.h"
#include "tests/use_asset.h"

namespace penumbra::test_blockers_asset {
namespace {

SphereBlockers someBlockers(std::size_t count) {
    SphereBlockers blockers;
    for (std::size_t s = 0; s < count; ++s) {
        blockers.spheres.push_back({{float(s), 0.5f, -float(s)}, 0.25f + float(s)});
        blockers.joints.push_back(std::uint16_t(s % 3));
    }
    return blockers;
}

std::vector<std::byte> packedWith(SphereBlockers blockers) {
    return packAsset(synthetic::tubeModel({.rings = 3, .segments = 3}), {}, {},
                     {.precision = AssetPrecision::kI8, .blockers = std::move(blockers)}, "{}", 1)
        .bytes;
}

TEST(BlockersAsset, HoldsTheSpheres) {
    const SphereBlockers blockers = someBlockers(15);
    const std::vector<std::byte> bytes = packedWith(blockers);
    const AssetView asset = openAsset(bytes);
    ASSERT_EQ(asset.blockers.spheres.size(), 15u);
    EXPECT_TRUE(std::equal(blockers.spheres.begin(), blockers.spheres.end(), asset.blockers.spheres.begin()));
    EXPECT_TRUE(std::equal(blockers.joints.begin(), blockers.joints.end(), asset.blockers.joints.begin()));
    useAsset(asset);
}

// 270 bytes of numbers, two lengths and two fields. Files are multiples of 16 bytes, so this one grows by 288.
TEST(BlockersAsset, FifteenSpheresTakeThreeHundredBytes) {
    const std::vector<std::byte> with = packedWith(someBlockers(15)), without = packedWith({});
    EXPECT_EQ(openAsset(with).blockers.byteCount(), 270u);
    EXPECT_LE(with.size() - without.size(), 304u);
    std::size_t listed = 0;
    for (const SizeOf& size : sectionSizes(openAsset(with), with.size()))
        if (size.section == "blockers") listed = size.bytes;
    EXPECT_EQ(listed, 270u);
    for (const SizeOf& size : sectionSizes(openAsset(without), without.size())) EXPECT_NE(size.section, "blockers");
}

TEST(BlockersAsset, AssetsWithoutBlockersHaveNoField) {
    const std::vector<std::byte> bytes = packedWith({});
    EXPECT_EQ(fbs::GetAsset(bytes.data())->blocker_spheres(), nullptr);
    EXPECT_TRUE(openAsset(bytes).blockers.spheres.empty());
}

template <class Change>
std::string refusalAfter(const Change& change) {
    return refusalOf(packedWith(someBlockers(3)), change);
}

TEST(BlockersAsset, WrongNumbersAreRefused) {
    const auto sphere = [](flatbuffers::uoffset_t at, float value) {
        return [at, value](fbs::Asset& a) { a.mutable_blocker_spheres()->Mutate(at, value); };
    };
    EXPECT_EQ(refusalAfter(sphere(0, 1)), "accepted");
    const std::string radius = "x.pnb: blocker_spheres[1] has a radius that is not in [1e-15, 1e15]";
    for (const float bad : {0.0f, -1.0f, NAN, INFINITY, 1e30f}) EXPECT_EQ(refusalAfter(sphere(7, bad)), radius) << bad;
    const std::string center = "x.pnb: blocker_spheres[2] has a center that is not finite, or above 1e15";
    for (const float bad : {NAN, -INFINITY, 1e30f}) EXPECT_EQ(refusalAfter(sphere(9, bad)), center) << bad;
    EXPECT_EQ(refusalAfter([](fbs::Asset& a) { a.mutable_blocker_joints()->Mutate(1, 3); }),
              "x.pnb: blocker_joints[1] is 3, beyond the last of 3");
}

TEST(BlockersAsset, WrongCountsAreRefused) {
    SphereBlockers blockers = someBlockers(3);
    blockers.joints.pop_back();
    EXPECT_THROW(packedWith(blockers), InvalidInput);
    EXPECT_THROW(packedWith(someBlockers(65)), InvalidInput);
    EXPECT_EQ(openAsset(packedWith(someBlockers(64))).blockers.spheres.size(), 64u);
}

TEST(BlockersAsset, RejectsEveryTruncation) { expectTruncationsRefused(packedWith(someBlockers(2))); }

}  // namespace
}  // namespace penumbra::test_blockers_asset
