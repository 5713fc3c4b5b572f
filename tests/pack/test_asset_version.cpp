// An asset is refused by the number of another version, and by the name of a required field that it lacks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "asset_generated.h"
#include "tests/fuzz/tiny_inputs.h"
#include "tests/pack/changed_asset.h"

namespace penumbra::test_asset_version {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(AssetVersion, IsOneWhateverAnAssetHolds) {
    for (const std::vector<std::byte>& asset : tinyAssets()) {
        EXPECT_EQ(refusalOf(asset), "accepted");
        EXPECT_EQ(fbs::GetAsset(asset.data())->format_version(), 1);
    }
}

// A file of another version may have other fields, so nothing but its number may matter.
TEST(AssetVersion, OthersAreRefusedByTheirNumbers) {
    for (const int version : {0, 2, 8, 65535}) {
        std::vector<std::byte> bytes = tinyAssets().front();
        fbs::GetMutableAsset(bytes.data())->mutate_format_version(std::uint16_t(version));
        const std::string expected = "x.pnb: is version " + std::to_string(version) +
                                     " of penumbra.asset, and this build reads version 1 alone: make the file again "
                                     "with this build";
        EXPECT_EQ(refusalOf(bytes), expected);
        const auto* mesh = reinterpret_cast<const std::uint8_t*>(fbs::GetAsset(bytes.data())->mesh());
        const auto at = std::size_t(mesh - reinterpret_cast<const std::uint8_t*>(bytes.data()));
        std::fill(bytes.begin() + std::ptrdiff_t(at), bytes.end(), std::byte{0xee});
        EXPECT_EQ(refusalOf(bytes), expected);
    }
}

// Takes a field out of a table. Tables share the list of where their fields are, so this one gets a list of its own, at
// the end of the file.
void drop(std::vector<std::byte>& bytes, const void* table, flatbuffers::voffset_t field) {
    using flatbuffers::ReadScalar;
    const auto* start = static_cast<const std::byte*>(table);
    const std::byte* fields = start - ReadScalar<flatbuffers::soffset_t>(start);
    std::vector<std::byte> own(fields, fields + ReadScalar<flatbuffers::voffset_t>(fields));
    ASSERT_NE(ReadScalar<flatbuffers::voffset_t>(own.data() + field), 0) << "is not there";
    flatbuffers::WriteScalar<flatbuffers::voffset_t>(own.data() + field, 0);
    const auto at = start - bytes.data(), end = std::ptrdiff_t(bytes.size());
    flatbuffers::WriteScalar(bytes.data() + at, flatbuffers::soffset_t(at - end));
    bytes.insert(bytes.end(), own.begin(), own.end());
}

struct Missing {
    const char* name;
    const void* (*table)(const fbs::Asset&);
    flatbuffers::voffset_t field;
};

void expectNamed(const std::vector<std::byte>& whole, const std::vector<Missing>& fields) {
    for (const Missing& missing : fields) {
        std::vector<std::byte> bytes = whole;
        drop(bytes, missing.table(*fbs::GetAsset(bytes.data())), missing.field);
        ASSERT_TRUE(sealAsset(bytes)) << missing.name;
        EXPECT_THAT(refusalOf(bytes), StartsWith(std::string("x.pnb: ") + missing.name));
    }
}

const void* meshOf(const fbs::Asset& asset) { return asset.mesh(); }
const void* animationOf(const fbs::Asset& asset) { return asset.animation(); }
const void* modelOf(const fbs::Asset& asset) { return asset.model(); }
const void* clusterOf(const fbs::Asset& asset) { return asset.model()->clusters()->Get(0); }
const void* materialOf(const fbs::Asset& asset) { return asset.materials()->Get(0); }
const void* lightOf(const fbs::Asset& asset) { return asset.lights()->Get(0); }

TEST(AssetVersion, MissingFieldsOfACharacterAreNamed) {
    BrdfFile brdf = synthetic::lambert();
    LightFile light = tinySunny();
    const std::vector<std::byte> whole =
        packAsset(synthetic::tubeModel({.kind = ModelKind::kAdditive}), std::vector<BrdfFile>{brdf},
                  std::vector<LightFile>{light}, {}, "{}", 1)
            .bytes;
    expectNamed(whole, {{"mesh.positions", meshOf, fbs::Mesh::VT_POSITIONS},
                        {"mesh.normals", meshOf, fbs::Mesh::VT_NORMALS},
                        {"mesh.tangents", meshOf, fbs::Mesh::VT_TANGENTS},
                        {"mesh.triangles", meshOf, fbs::Mesh::VT_TRIANGLES},
                        {"mesh.shading_point", meshOf, fbs::Mesh::VT_SHADING_POINT},
                        {"mesh.source_vertex", meshOf, fbs::Mesh::VT_SOURCE_VERTEX},
                        {"mesh.influences", meshOf, fbs::Mesh::VT_INFLUENCES},
                        {"mesh.skin_joints", meshOf, fbs::Mesh::VT_SKIN_JOINTS},
                        {"mesh.skin_weights", meshOf, fbs::Mesh::VT_SKIN_WEIGHTS},
                        {"animation.joint_names", animationOf, fbs::Animation::VT_JOINT_NAMES},
                        {"animation.parents", animationOf, fbs::Animation::VT_PARENTS},
                        {"animation.clips", animationOf, fbs::Animation::VT_CLIPS},
                        {"animation.times", animationOf, fbs::Animation::VT_TIMES},
                        {"animation.bones", animationOf, fbs::Animation::VT_BONES},
                        {"model.stride", modelOf, fbs::Model::VT_STRIDE},
                        {"model.feature_scale", modelOf, fbs::Model::VT_FEATURE_SCALE},
                        {"model.joint_centers", modelOf, fbs::Model::VT_JOINT_CENTERS},
                        {"model.joint_spreads", modelOf, fbs::Model::VT_JOINT_SPREADS},
                        {"model.clusters", modelOf, fbs::Model::VT_CLUSTERS},
                        {"model.clusters[0].center", clusterOf, fbs::Cluster::VT_CENTER},
                        {"model.clusters[0].input_min is missing", clusterOf, fbs::Cluster::VT_INPUT_MIN},
                        {"model.clusters[0].groups is missing", clusterOf, fbs::Cluster::VT_GROUPS},
                        {"model.clusters[0].group_weight", clusterOf, fbs::Cluster::VT_GROUP_WEIGHT},
                        {"model.clusters[0].group_min", clusterOf, fbs::Cluster::VT_GROUP_MIN},
                        {"model.clusters[0].group_max", clusterOf, fbs::Cluster::VT_GROUP_MAX},
                        {"model.clusters[0].hidden", clusterOf, fbs::Cluster::VT_HIDDEN},
                        {"model.clusters[0].unit_group is missing", clusterOf, fbs::Cluster::VT_UNIT_GROUP},
                        {"model.clusters[0].weights", clusterOf, fbs::Cluster::VT_WEIGHTS},
                        {"model.clusters[0].bias is missing", clusterOf, fbs::Cluster::VT_BIAS},
                        {"model.clusters[0].mean", clusterOf, fbs::Cluster::VT_MEAN},
                        {"model.clusters[0].basis", clusterOf, fbs::Cluster::VT_BASIS},
                        {"materials[0].slice_order", materialOf, fbs::Material::VT_SLICE_ORDER},
                        {"materials[0].channels", materialOf, fbs::Material::VT_CHANNELS},
                        {"materials[0].color", materialOf, fbs::Material::VT_COLOR},
                        {"materials[0].slices is missing", materialOf, fbs::Material::VT_SLICES},
                        {"materials[0].lobes is missing", materialOf, fbs::Material::VT_LOBES},
                        {"lights[0].order", lightOf, fbs::Light::VT_ORDER},
                        {"lights[0].sh", lightOf, fbs::Light::VT_SH},
                        {"lights[0].picture ", lightOf, fbs::Light::VT_PICTURE}});
}

TEST(AssetVersion, MissingFieldsOfAComposedModelAreNamed) {
    Model model = tinyComposed();
    synthetic::addIndirect(model);
    const SphereBlockers blockers{{{{0, 1, 0}, 0.5f}}, {1}};
    const std::vector<std::byte> whole = packAsset(model, {}, {}, {.blockers = blockers}, "{}", 1).bytes;
    const auto composition = [](const fbs::Asset& asset) -> const void* { return asset.model()->composition(); };
    const auto part = [](const fbs::Asset& asset) -> const void* {
        return asset.model()->composition()->fields()->Get(0);
    };
    const auto indirect = [](const fbs::Asset& asset) -> const void* { return asset.model()->indirect(); };
    const auto root = [](const fbs::Asset& asset) -> const void* { return &asset; };
    expectNamed(whole, {{"model.composition.steps", composition, fbs::Composition::VT_STEPS},
                        {"model.composition.part_of_vertex", composition, fbs::Composition::VT_PART_OF_VERTEX},
                        {"model.composition.near_parts", composition, fbs::Composition::VT_NEAR_PARTS},
                        {"model.composition.near_gains", composition, fbs::Composition::VT_NEAR_GAINS},
                        {"model.composition.fields is missing", composition, fbs::Composition::VT_FIELDS},
                        {"model.composition.fade", composition, fbs::Composition::VT_FADE},
                        {"model.composition.fields[0].center", part, fbs::PartField::VT_CENTER},
                        {"model.composition.fields[0].radius", part, fbs::PartField::VT_RADIUS},
                        {"model.composition.fields[0].boxes", part, fbs::PartField::VT_BOXES},
                        {"model.composition.fields[0].scale", part, fbs::PartField::VT_SCALE},
                        {"model.composition.fields[0].distance_scale", part, fbs::PartField::VT_DISTANCE_SCALE},
                        {"model.composition.fields[0].values", part, fbs::PartField::VT_VALUES},
                        {"model.composition.fields[0].distances", part, fbs::PartField::VT_DISTANCES},
                        {"model.indirect.bounces", indirect, fbs::Indirect::VT_BOUNCES},
                        {"model.indirect.color_axes", indirect, fbs::Indirect::VT_COLOR_AXES},
                        {"model.indirect.clusters is missing", indirect, fbs::Indirect::VT_CLUSTERS},
                        {"blocker_joints", root, fbs::Asset::VT_BLOCKER_JOINTS},
                        {"mesh is missing", root, fbs::Asset::VT_MESH}});
}

TEST(AssetVersion, MissingFieldsOfTransferAreNamed) {
    const auto transfer = [](const fbs::Asset& asset) -> const void* { return asset.transfer(); };
    expectNamed(
        packTransfer(synthetic::tubeTransfer(TransferModelKind::kPca, 2, {.rings = 2, .segments = 3, .joints = 2}),
                     std::vector<BrdfFile>{diffuseMaterial({0.5f, 0.5f, 0.5f})}, {}, {}, "{}"),
        {{"transfer.order", transfer, fbs::Transfer::VT_ORDER},
         {"transfer.angles", transfer, fbs::Transfer::VT_ANGLES},
         {"transfer.pose_basis", transfer, fbs::Transfer::VT_POSE_BASIS},
         {"transfer.weights", transfer, fbs::Transfer::VT_WEIGHTS},
         {"transfer.mean", transfer, fbs::Transfer::VT_MEAN}});
}

}  // namespace
}  // namespace penumbra::test_asset_version
