#include <gtest/gtest.h>

#include <cstring>

#include "asset_generated.h"
#include "formats/asset/asset_file.h"
#include "formats/asset/mapped_file.h"
#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "pack/sections/asset_writer.h"
#include "pack/sections/material_section.h"
#include "tests/pack/changed_asset.h"
#include "tests/refusal.h"
#include "tests/synthetic_model.h"
#include "tests/use_asset.h"

namespace penumbra::test_asset_file {
namespace {

std::vector<std::byte> tinyAsset(AssetPrecision precision = AssetPrecision::kI8) {
    const std::vector<BrdfFile> brdfs = {synthetic::lambert()};
    const std::vector<LightFile> lights = {synthetic::light(4, 0.3)};
    return packAsset(synthetic::tubeModel(), brdfs, lights, {.precision = precision, .max_error = {}}, "{}", 1).bytes;
}

TEST(AssetFile, RejectsEveryTruncation) { expectTruncationsRefused(tinyAsset()); }

TEST(AssetFile, RejectsEveryChangedByteByItsHash) {
    std::vector<std::byte> bytes = tinyAsset();
    std::size_t accepted = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        bytes[at] ^= std::byte{0x10};
        try {
            openAsset(bytes);
            ++accepted;
        } catch (const InvalidInput&) {
        }
        bytes[at] ^= std::byte{0x10};
    }
    EXPECT_EQ(accepted, 0u);
}

// The hash is put right after every mutation, so that the checks behind it are tested.
TEST(AssetFile, MutationsAreRefusedOrHarmless) {
    const std::vector<std::byte> whole = tinyAsset();
    std::mt19937 random(5);
    int refused = 0, used = 0;
    for (int trial = 0; trial < 10000; ++trial) {
        std::vector<std::byte> bytes = whole;
        const int changes = 1 + int(random() % 4);
        for (int i = 0; i < changes; ++i) {
            const std::size_t at = random() % bytes.size();
            if (random() % 2)
                bytes[at] ^= std::byte(1u << random() % 8);
            else
                bytes[at] = std::byte(random());
        }
        sealAsset(bytes);
        try {
            const AssetView asset = openAsset(bytes);
            ++used;
            useAsset(asset);
        } catch (const InvalidInput&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 500);
    EXPECT_GT(used, 500);
}

template <class Change>
std::string refusalAfter(const Change& change) {
    return refusalOf(tinyAsset(AssetPrecision::kF32), change);
}

TEST(AssetFile, NamesTheFieldThatIsWrong) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    using fbs::Asset;
    EXPECT_EQ(refusalAfter([](Asset&) {}), "accepted");
    const auto expect = [](const std::string& message, const std::string& part) {
        EXPECT_NE(message.find(part), std::string::npos) << message << " should say " << part;
        EXPECT_EQ(message.find("x.pnb: "), 0u) << message;
    };
    expect(refusalAfter([&](Asset& a) { a.mutable_mesh()->mutable_positions()->Mutate(4, nan); }), "mesh.positions");
    expect(refusalAfter([](Asset& a) { a.mutable_mesh()->mutable_normals()->Mutate(0, 3.0f); }), "mesh.normals[0]");
    expect(refusalAfter([](Asset& a) { a.mutable_mesh()->mutable_triangles()->Mutate(7, 30); }), "mesh.triangles[7]");
    expect(refusalAfter([](Asset& a) { a.mutable_mesh()->mutable_shading_point()->Mutate(3, 0); }), "shading_point");
    expect(refusalAfter([](Asset& a) { a.mutable_mesh()->mutable_source_vertex()->Mutate(0, 99); }), "source_vertex");
    expect(refusalAfter([](Asset& a) { a.mutable_mesh()->mutable_skin_joints()->Mutate(1, 3); }), "skin_joints[1]");
    expect(refusalAfter([](Asset& a) { a.mutable_mesh()->mutable_skin_weights()->Mutate(0, 0.4f); }), "skin_weights");
    expect(refusalAfter([](Asset& a) { a.mutable_animation()->mutable_parents()->Mutate(0, 2); }), "cycle");
    expect(refusalAfter([](Asset& a) { a.mutable_animation()->mutable_times()->Mutate(1, INFINITY); }), "times");
    expect(refusalAfter([&](Asset& a) { a.mutable_animation()->mutable_bones()->Mutate(9, nan); }), "bones");
    const auto cluster = [](Asset& a) {
        return const_cast<fbs::Cluster*>(a.mutable_model()->mutable_clusters()->GetMutableObject(1));
    };
    expect(refusalAfter([&](Asset& a) { cluster(a)->mutate_joint(3); }), "model.clusters[1].joint");
    expect(refusalAfter([&](Asset& a) { cluster(a)->mutate_first_vertex(0); }), "model.clusters[1].first_vertex");
    expect(refusalAfter([&](Asset& a) { cluster(a)->mutable_bias()->Mutate(0, nan); }), "model.clusters[1].bias");
    expect(refusalAfter([&](Asset& a) { cluster(a)->mutable_input_max()->Mutate(0, -2); }), "input_max[0]");
    expect(refusalAfter([&](Asset& a) { cluster(a)->mutable_groups()->Mutate(0, 3); }), "model.clusters[1].groups[0]");
    expect(refusalAfter([&](Asset& a) { cluster(a)->mutable_group_weight()->Mutate(0, nan); }), "group_weight");
    expect(refusalAfter([&](Asset& a) { a.mutable_model()->mutable_joint_spreads()->Mutate(0, nan); }),
           "joint_spreads");
    expect(refusalAfter([&](Asset& a) { cluster(a)->mutable_basis()->mutate_count(4); }), "basis.count");
    expect(refusalAfter([&](Asset& a) {
               cluster(a)->mutable_basis()->mutable_data()->Mutate(3, 0xff);
               cluster(a)->mutable_basis()->mutable_data()->Mutate(2, 0x80);
           }),
           "basis.data");
    expect(refusalAfter([](Asset& a) { a.mutable_model()->mutate_stride(20); }), "model.stride");
    expect(refusalAfter([&](Asset& a) { a.mutable_lights()->GetMutableObject(0)->mutable_sh()->Mutate(0, nan); }),
           "lights[0].sh");
    const auto material = [](Asset& a) { return a.mutable_materials()->GetMutableObject(0); };
    expect(refusalAfter([&](Asset& a) { material(a)->mutate_channels(2); }), "materials[0].channels");
    expect(refusalAfter([&](Asset& a) { material(a)->mutate_slice_form(fbs::SliceForm(3)); }),
           "materials[0].slice_form is 3");
    expect(refusalAfter([&](Asset& a) { material(a)->mutate_slice_form(fbs::SliceForm::Orthotropic); }),
           "materials[0].slices has 32 elements, expected 102");
    expect(refusalAfter([&](Asset& a) { material(a)->mutate_slice_form(fbs::SliceForm::General); }),
           "materials[0].slices has 32 elements, expected 375");
    expect(refusalAfter([&](Asset& a) { material(a)->mutate_view_order(4); }), "materials[0].slices has 32 elements");
    expect(refusalAfter([&](Asset& a) { material(a)->mutable_slices()->Mutate(31, nan); }), "materials[0].slices");
}

// Compact slices unfold to more than the file has. One material that is listed a million times must not fill the
// memory.
TEST(AssetFile, RefusesMoreMaterialsThanThereMayBe) {
    const auto openWith = [](std::size_t count) {
        FlatBufferBuilder builder;
        AssetSections sections;
        sections.materials.assign(count, writeMaterial(builder, synthetic::lambert()));
        const std::span<std::byte> finished = finishAsset(builder, sections, 5, "{}");
        const std::vector<std::byte> bytes(finished.begin(), finished.end());
        return refusalBy([&] { openAsset(bytes); });
    };
    EXPECT_EQ(openWith(1), "accepted");
    EXPECT_EQ(openWith(kMaxMaterials), "asset: materials has \"lambert\" twice");
    EXPECT_EQ(openWith(kMaxMaterials + 1), "asset: materials is 4097, allowed are 0..4096");
}

TEST(AssetFile, RefusesBytesThatAreNotAligned) {
    const std::vector<std::byte> whole = tinyAsset();
    std::vector<std::byte> shifted(whole.size() + 8);
    std::copy(whole.begin(), whole.end(), shifted.begin() + 8);
    EXPECT_THROW(openAsset(std::span(shifted).subspan(8)), InvalidInput);
}

TEST(AssetFile, MapsWhatWasWritten) {
    const auto path = std::filesystem::temp_directory_path() / ("tiny" + std::to_string(::getpid()) + ".pnb");
    const std::vector<std::byte> whole = tinyAsset();
    writeWholeFile(path, whole);
    {
        const MappedFile file(path);
        EXPECT_EQ(std::memcmp(file.bytes().data(), whole.data(), whole.size()), 0);
        EXPECT_EQ(openAsset(file.bytes()).mesh.positions.size(), 30u);
    }
    std::filesystem::remove(path);
    EXPECT_THROW(MappedFile{path}, IoError);
    EXPECT_THROW(MappedFile{std::filesystem::temp_directory_path()}, IoError);
}

TEST(AssetFile, TellsWhichClipsAreHeldOut) {
    const std::vector<std::byte> whole = tinyAsset();
    const AssetView asset = openAsset(whole);
    EXPECT_FALSE(asset.animation.clips[0].held_out);
    EXPECT_TRUE(asset.animation.clips[1].held_out);
}

}  // namespace
}  // namespace penumbra::test_asset_file
