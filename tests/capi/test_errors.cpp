// Every wrong call gets its status and a sentence, and changes nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>

#include "tests/capi/packed_asset.h"
#include "tests/no_simd.h"

namespace penumbra::test_errors {
namespace {

using namespace capi_test;
using testing::HasSubstr;

// Holds what a call says, as "STATUS: message".
class Said {
public:
    penumbra_error error{PENUMBRA_FAILED, "not written"};
    std::string after(penumbra_status status) const {
        EXPECT_EQ(status, error.status);
        EXPECT_EQ(status == PENUMBRA_OK, error.message[0] == 0);
        return std::string(penumbra_status_name(status)) + ": " + error.message;
    }
};

struct Whole {
    std::vector<std::byte> bytes;
    Asset asset;
    Character character;
    Shading shading;
    penumbra_asset_info info;

    explicit Whole(const Recipe& recipe = {}, const penumbra_shading_options& options = {})
        : bytes(packed(recipe)),
          asset(open(bytes)),
          character(capi_test::character(asset)),
          shading(capi_test::shading(asset, options)),
          info(infoOf(asset)) {}
};

TEST(CApiErrors, NamesOfStatuses) {
    EXPECT_STREQ(penumbra_status_name(PENUMBRA_OK), "PENUMBRA_OK");
    EXPECT_STREQ(penumbra_status_name(PENUMBRA_OUT_OF_MEMORY), "PENUMBRA_OUT_OF_MEMORY");
    EXPECT_STREQ(penumbra_status_name(penumbra_status(7)), "unknown status");
    EXPECT_EQ(penumbra_asset_format_version(), kAssetFormat.version);
    EXPECT_STREQ(penumbra_version(), "0.1.0");
}

TEST(CApiErrors, Opening) {
    const std::filesystem::path folder = testing::TempDir() + "capi_opening";
    std::filesystem::create_directories(folder);
    Said said;
    penumbra_asset* asset = nullptr;
    const auto file = [&](const std::filesystem::path& path) {
        return said.after(penumbra_asset_open_file(path.c_str(), &asset, &said.error));
    };
    const std::string missing = (folder / "missing.pnb").string();
    EXPECT_EQ(file(missing), "PENUMBRA_IO_ERROR: " + missing + ": cannot open: No such file or directory");
    EXPECT_THAT(file(folder), HasSubstr("PENUMBRA_IO_ERROR: " + folder.string() + ": not a regular file"));
    std::ofstream(folder / "empty.pnb").flush();
    EXPECT_EQ(file(folder / "empty.pnb"), "PENUMBRA_INVALID_ASSET: " + (folder / "empty.pnb").string() +
                                              ": not a Penumbra asset (PNB1), or cut short");
    std::ofstream(folder / "text.pnb") << "this is no asset, though it has more than a few bytes";
    EXPECT_THAT(file(folder / "text.pnb"), HasSubstr("text.pnb: not a Penumbra asset (PNB1), or cut short"));
    EXPECT_THAT(file(folder / std::string(2000, 'x')), HasSubstr("PENUMBRA_IO_ERROR"));  // the message is cut
    EXPECT_EQ(std::string(said.error.message).size(), sizeof said.error.message - 1);
    EXPECT_EQ(asset, nullptr);
    EXPECT_EQ(penumbra_asset_open_file(nullptr, &asset, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_open_file(missing.c_str(), nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    const std::vector<std::byte> bytes = packed();
    std::ofstream(folder / "good.pnb", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    EXPECT_EQ(file(folder / "good.pnb"), "PENUMBRA_OK: ");
    penumbra_asset_close(asset);
    std::filesystem::remove_all(folder);
}

// These are refused at once: opening a pipe would wait for its writer, and a device has no end.
TEST(CApiErrors, OpeningWhatIsNoFile) {
    const std::filesystem::path folder = testing::TempDir() + "capi_opening_no_file";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    ASSERT_EQ(::mkfifo((folder / "pipe.pnb").c_str(), 0600), 0);
    std::filesystem::create_symlink("pipe.pnb", folder / "link.pnb");
    Said said;
    penumbra_asset* asset = nullptr;
    for (const std::string& path :
         {(folder / "pipe.pnb").string(), (folder / "link.pnb").string(), folder.string(), std::string("/dev/zero")})
        EXPECT_EQ(said.after(penumbra_asset_open_file(path.c_str(), &asset, &said.error)),
                  "PENUMBRA_IO_ERROR: " + path + ": not a regular file");
    EXPECT_EQ(asset, nullptr);
    std::filesystem::remove_all(folder);
}

TEST(CApiErrors, OpeningBytes) {
    const std::vector<std::byte> bytes = packed();
    std::vector<std::byte> shifted(bytes.size() + 1);
    std::copy(bytes.begin(), bytes.end(), shifted.begin() + 1);
    Said said;
    penumbra_asset* asset = nullptr;
    const auto memory = [&](const void* p, std::size_t size, int ownership) {
        return said.after(penumbra_asset_open_memory(p, size, penumbra_ownership(ownership), &asset, &said.error));
    };
    EXPECT_EQ(memory(shifted.data() + 1, bytes.size(), PENUMBRA_BORROW),
              "PENUMBRA_INVALID_ARGUMENT: bytes to be read in place must begin at a multiple of 16");
    EXPECT_THAT(memory(bytes.data(), bytes.size(), 2), HasSubstr("ownership must be"));
    EXPECT_EQ(memory(nullptr, 9, PENUMBRA_COPY), "PENUMBRA_INVALID_ARGUMENT: bytes is NULL");
    // Nothing behind the bytes is read before such a size is refused.
    EXPECT_EQ(memory(bytes.data(), std::size_t(1) << 40, PENUMBRA_COPY),
              "PENUMBRA_INVALID_ASSET: asset: 1099511627776 bytes are more than an asset can have");
    EXPECT_THAT(memory(bytes.data(), 0, PENUMBRA_BORROW), HasSubstr("PENUMBRA_INVALID_ASSET"));
    EXPECT_THAT(memory(bytes.data(), bytes.size() - 1, PENUMBRA_BORROW), HasSubstr("PENUMBRA_INVALID_ASSET"));
    EXPECT_EQ(asset, nullptr);
    // A copy needs neither the place nor the life of the bytes.
    EXPECT_EQ(memory(shifted.data() + 1, bytes.size(), PENUMBRA_COPY), "PENUMBRA_OK: ");
    const Asset copy(asset);
    shifted.assign(shifted.size(), std::byte(0));
    EXPECT_EQ(infoOf(copy).vertex_count, 30u);
    EXPECT_TRUE(character(copy));
}

TEST(CApiErrors, Queries) {
    const Whole x;
    EXPECT_EQ(penumbra_asset_get_info(x.asset.get(), nullptr), PENUMBRA_INVALID_ARGUMENT);
    penumbra_asset_info info;
    EXPECT_EQ(penumbra_asset_get_info(nullptr, &info), PENUMBRA_INVALID_ARGUMENT);
    const auto everyIndex = [&](auto get, auto out, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(get(x.asset.get(), i, &out), PENUMBRA_OK);
        EXPECT_EQ(get(x.asset.get(), count, &out), PENUMBRA_INVALID_ARGUMENT);
        EXPECT_EQ(get(x.asset.get(), SIZE_MAX, &out), PENUMBRA_INVALID_ARGUMENT);
        EXPECT_EQ(get(nullptr, 0, &out), PENUMBRA_INVALID_ARGUMENT);
        EXPECT_EQ(get(x.asset.get(), 0, nullptr), PENUMBRA_INVALID_ARGUMENT);
    };
    everyIndex(penumbra_asset_get_clip, penumbra_clip{}, 2);
    everyIndex(penumbra_asset_get_frame, penumbra_frame{}, 4);
    everyIndex(penumbra_asset_get_material, penumbra_material{}, 2);
    everyIndex(penumbra_asset_get_light, penumbra_light{}, 2);
    everyIndex(penumbra_asset_get_cluster, penumbra_cluster{}, 2);
    EXPECT_EQ(penumbra_asset_joint_name(x.asset.get(), 3), nullptr);
    EXPECT_EQ(penumbra_asset_joint_name(nullptr, 0), nullptr);
    EXPECT_EQ(penumbra_asset_slot_name(x.asset.get(), 2), nullptr);
    EXPECT_EQ(penumbra_asset_find_clip(x.asset.get(), "walk"), PENUMBRA_NONE);
    EXPECT_EQ(penumbra_asset_find_clip(x.asset.get(), nullptr), PENUMBRA_NONE);
    EXPECT_EQ(penumbra_asset_find_joint(nullptr, "joint0"), PENUMBRA_NONE);
    EXPECT_EQ(penumbra_asset_frame_at(x.asset.get(), 2, 0), PENUMBRA_NONE);
}

TEST(CApiErrors, WhatTheQueriesSay) {
    const Whole x;
    const AssetView view = openAsset(x.bytes);
    EXPECT_EQ(x.info.has_model, 1);
    EXPECT_STREQ(x.info.provenance, "{}");
    EXPECT_EQ(x.info.vertex_count, 30u);
    EXPECT_EQ(x.info.source_vertex_count, 30u);
    EXPECT_EQ(x.info.triangle_count, view.mesh.triangles.size() / 3);
    EXPECT_EQ(x.info.triangles, view.mesh.triangles.data());
    EXPECT_EQ(x.info.rest_tangents, &view.mesh.tangents[0].x);
    EXPECT_EQ(x.info.influence_count, 2u);
    EXPECT_EQ(x.info.skin_weights, view.mesh.skin_weights.data());
    EXPECT_EQ(x.info.slot_of_vertex, view.mesh.slot_of_vertex.data());
    EXPECT_EQ(x.info.joint_count, 3u);
    EXPECT_EQ(x.info.joint_parents[2], 1);
    EXPECT_EQ(x.info.rotation_count, 0u) << "a model of relative bones needs none";
    EXPECT_STREQ(x.info.convention, "D5");
    EXPECT_EQ(x.info.coefficient_count, 15u);
    EXPECT_EQ(x.info.stride, 16u);
    EXPECT_EQ(x.info.score_count, 6u);
    EXPECT_EQ(x.info.quantization_error, view.model.quantization_error);
    EXPECT_STREQ(penumbra_asset_joint_name(x.asset.get(), 1), "joint1");
    EXPECT_STREQ(penumbra_asset_slot_name(x.asset.get(), 1), "body/cloth");
    EXPECT_EQ(penumbra_asset_find_joint(x.asset.get(), "joint2"), 2u);
    EXPECT_EQ(penumbra_asset_find_slot(x.asset.get(), "body/cloth"), 1u);
    EXPECT_EQ(penumbra_asset_find_material(x.asset.get(), "tinted"), 1u);
    EXPECT_EQ(penumbra_asset_find_light(x.asset.get(), "noise"), 1u);
    penumbra_clip clip;
    ASSERT_EQ(penumbra_asset_get_clip(x.asset.get(), penumbra_asset_find_clip(x.asset.get(), "twist"), &clip),
              PENUMBRA_OK);
    EXPECT_STREQ(clip.name, "twist");
    EXPECT_EQ(clip.first_frame, 2u);
    EXPECT_EQ(clip.frame_count, 2u);
    EXPECT_EQ(clip.held_out, 1);
    penumbra_frame frame;
    ASSERT_EQ(penumbra_asset_get_frame(x.asset.get(), 3, &frame), PENUMBRA_OK);
    EXPECT_EQ(frame.seconds, 1 / 3.0);
    EXPECT_EQ(frame.matrices, view.animation.bonesOf(3)[0].m.data());
    const double times[] = {-1, 0, 0.3, 0.34, 99};
    const std::size_t frames[] = {2, 2, 2, 3, 3};
    for (int i = 0; i < 5; ++i) EXPECT_EQ(penumbra_asset_frame_at(x.asset.get(), 1, times[i]), frames[i]) << times[i];
    EXPECT_EQ(penumbra_asset_frame_at(x.asset.get(), 1, NAN), PENUMBRA_NONE);
    penumbra_material material;
    ASSERT_EQ(penumbra_asset_get_material(x.asset.get(), 1, &material), PENUMBRA_OK);
    EXPECT_STREQ(material.name, "tinted");
    EXPECT_EQ(material.channels, 3);
    EXPECT_EQ(material.operator_count, 2);
    penumbra_light light;
    ASSERT_EQ(penumbra_asset_get_light(x.asset.get(), 1, &light), PENUMBRA_OK);
    EXPECT_EQ(light.order, 4);
    EXPECT_EQ(light.lobe_count, 2);
}

TEST(CApiErrors, Poses) {
    Recipe recipe;
    recipe.tube.features = FeatureKind::kJointAngles;
    const Whole x(recipe);
    Said said;
    const auto pose = [&](int layout, const std::vector<float>* matrices, std::size_t joints,
                          const std::vector<float>* rotations, std::size_t count) {
        return said.after(penumbra_character_set_pose(x.character.get(), penumbra_matrix_layout(layout),
                                                      matrices ? matrices->data() : nullptr, joints,
                                                      rotations ? rotations->data() : nullptr, count, &said.error));
    };
    Frame before(x.info), after(x.info);
    penumbra_character_set_frame(x.character.get(), 1, nullptr);
    before.evaluate(x.character.get(), x.info);
    std::vector<float> matrices(36, 0.5f), rotations(9, 0.1f);
    EXPECT_EQ(pose(0, nullptr, 3, &rotations, 9), "PENUMBRA_INVALID_ARGUMENT: matrices is NULL");
    EXPECT_EQ(pose(0, &matrices, 2, &rotations, 9), "PENUMBRA_INVALID_ARGUMENT: joint_count is 2; the asset has 3");
    EXPECT_THAT(pose(2, &matrices, 3, &rotations, 9), HasSubstr("layout is not a penumbra_matrix_layout"));
    EXPECT_EQ(pose(0, &matrices, 3, nullptr, 9),
              "PENUMBRA_INVALID_ARGUMENT: the model reads joint rotations: rotations is NULL");
    EXPECT_THAT(pose(0, &matrices, 3, &rotations, 8), HasSubstr("rotation_count is 8; the asset has 9"));
    rotations[4] = std::numeric_limits<float>::infinity();
    EXPECT_EQ(pose(0, &matrices, 3, &rotations, 9), "PENUMBRA_INVALID_ARGUMENT: rotations[4] is not finite");
    rotations[4] = 0;
    matrices[35] = NAN;
    EXPECT_EQ(pose(0, &matrices, 3, &rotations, 9), "PENUMBRA_INVALID_ARGUMENT: matrices[35] is not finite");
    EXPECT_EQ(penumbra_character_set_frame(x.character.get(), 4, &said.error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_STREQ(said.error.message, "frame is 4; there are 4");
    after.evaluate(x.character.get(), x.info);
    EXPECT_EQ(before.coefficients, after.coefficients) << "a refused pose changes nothing";
    matrices[35] = 0;
    EXPECT_EQ(pose(0, &matrices, 3, &rotations, 9), "PENUMBRA_OK: ");
    EXPECT_EQ(penumbra_character_set_pose(nullptr, PENUMBRA_ROWS_3X4, matrices.data(), 3, rotations.data(), 9, nullptr),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_out_of_range(nullptr), 0);
}

TEST(CApiErrors, ArraysAndRanges) {
    const Whole x;
    Frame frame(x.info);
    const Frame untouched(x.info);
    const penumbra_character* c = x.character.get();
    Said said;
    float *p = frame.positions.data(), *e = frame.ambient.data();
    const penumbra_vertices all = frame.vertices();
    const auto without = [&](float* penumbra_vertices::*array) {
        penumbra_vertices some = all;
        some.*array = nullptr;
        return some;
    };
    const penumbra_vertices none = without(&penumbra_vertices::coefficients);
    const auto evaluate = [&](std::size_t first, std::size_t count, const penumbra_vertices& out) {
        return said.after(penumbra_character_evaluate(c, first, count, &out, &said.error));
    };
    EXPECT_EQ(evaluate(1, 2, all), "PENUMBRA_INVALID_ARGUMENT: 2 clusters from 1 on; there are 2");
    EXPECT_THAT(evaluate(3, 0, all), HasSubstr("INVALID"));
    EXPECT_THAT(evaluate(1, SIZE_MAX, all), HasSubstr("INVALID"));
    EXPECT_EQ(evaluate(0, 2, none), "PENUMBRA_INVALID_ARGUMENT: vertices->coefficients is NULL");
    EXPECT_EQ(evaluate(2, 0, all), "PENUMBRA_OK: ");
    const penumbra_vertices beyond = frame.vertices(30, 1), too_many = frame.vertices(0, 31),
                            nobody = frame.vertices(30, 0);
    EXPECT_EQ(penumbra_character_skin(c, &beyond, nullptr), PENUMBRA_INVALID_ARGUMENT);
    std::vector<float> transfer(9 * 30);
    const auto transferOf = [&](int order, const penumbra_vertices* from, float* to) {
        return penumbra_character_transfer(c, order, from, to, nullptr);
    };
    for (const auto array :
         {&penumbra_vertices::positions, &penumbra_vertices::normals, &penumbra_vertices::tangents}) {
        const penumbra_vertices some = without(array);
        EXPECT_EQ(penumbra_character_skin(c, &some, nullptr), PENUMBRA_INVALID_ARGUMENT);
        EXPECT_EQ(transferOf(3, &some, transfer.data()), PENUMBRA_INVALID_ARGUMENT);
    }
    EXPECT_EQ(penumbra_character_skin(c, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_skin(nullptr, &all, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_skin(c, &nobody, nullptr), PENUMBRA_OK);
    EXPECT_EQ(penumbra_character_ambient(c, &too_many, e, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_ambient(c, &none, e, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_ambient(c, &all, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    for (const int order : {0, 6}) EXPECT_EQ(transferOf(order, &all, transfer.data()), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(transferOf(3, &too_many, transfer.data()), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(transferOf(3, &none, transfer.data()), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(transferOf(3, &all, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(frame.coefficients, untouched.coefficients);
    EXPECT_EQ(frame.positions, untouched.positions);
    EXPECT_EQ(penumbra_character_get_scores(nullptr, p, p), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_scores(c, nullptr, nullptr), PENUMBRA_OK);
}

TEST(CApiErrors, Simd) {
    const Whole x;
    Said said;
    EXPECT_EQ(penumbra_has_simd(PENUMBRA_SIMD_BEST), 1);
    EXPECT_EQ(penumbra_has_simd(PENUMBRA_SIMD_PORTABLE), 1);
    EXPECT_EQ(penumbra_has_simd(penumbra_simd(3)), 0);
    EXPECT_EQ(penumbra_character_set_simd(x.character.get(), penumbra_simd(3), &said.error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_set_quality(x.character.get(), penumbra_quality(2), &said.error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_set_quality(nullptr, PENUMBRA_FAST, nullptr), PENUMBRA_INVALID_ARGUMENT);
    const NoSimd no_simd;
    EXPECT_EQ(penumbra_has_simd(PENUMBRA_SIMD_AVX2), 0);
    EXPECT_EQ(penumbra_character_set_simd(x.character.get(), PENUMBRA_SIMD_AVX2, &said.error), PENUMBRA_UNSUPPORTED);
    EXPECT_EQ(penumbra_shading_set_simd(x.shading.get(), PENUMBRA_SIMD_AVX2, &said.error), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(said.error.message, HasSubstr("PENUMBRA_NO_SIMD"));
    EXPECT_EQ(penumbra_shading_set_simd(nullptr, PENUMBRA_SIMD_BEST, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_set_simd(nullptr, PENUMBRA_SIMD_BEST, nullptr), PENUMBRA_INVALID_ARGUMENT);
}

TEST(CApiErrors, MakingAShading) {
    const Whole x;
    const std::vector<std::byte> bare = packed({.materials = false, .lights = false});
    const std::vector<std::byte> unlit = packed({.lights = false});
    const Asset asset = open(bare), materials_only = open(unlit);
    Said said;
    penumbra_shading* made = nullptr;
    const auto make = [&](const Asset& from, penumbra_shading_options options) {
        return said.after(penumbra_shading_create(from.get(), nullptr, 0, &options, &made, &said.error));
    };
    EXPECT_EQ(make(asset, {}), "PENUMBRA_UNSUPPORTED: asset: there is no material");
    EXPECT_EQ(make(materials_only, {}), "PENUMBRA_UNSUPPORTED: asset: there is no light");
    EXPECT_EQ(make({}, {}), "PENUMBRA_INVALID_ARGUMENT: asset is NULL");
    EXPECT_THAT(make(x.asset, {penumbra_reflectance(2), PENUMBRA_ROTATION, 0}), HasSubstr("penumbra_reflectance"));
    EXPECT_THAT(make(x.asset, {PENUMBRA_SLICES, penumbra_light_form(3), 0}), HasSubstr("penumbra_light_form"));
    EXPECT_EQ(make(x.asset, {PENUMBRA_SLICES, PENUMBRA_ROTATION, 9}),
              "PENUMBRA_INVALID_ARGUMENT: caller_light_order is 9, allowed are 0..8");
    EXPECT_THAT(make(x.asset, {PENUMBRA_SLICES, PENUMBRA_FIXED_LOBES, 4}), HasSubstr("PENUMBRA_UNSUPPORTED"));
    const penumbra_asset* list[] = {nullptr};
    EXPECT_EQ(penumbra_shading_create(x.asset.get(), list, 1, nullptr, &made, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_create(x.asset.get(), nullptr, 1, nullptr, &made, nullptr), PENUMBRA_INVALID_ARGUMENT);
    const penumbra_asset* one[] = {x.asset.get()};
    EXPECT_EQ(
        said.after(penumbra_shading_create(x.asset.get(), one, std::size_t(1) << 60, nullptr, &made, &said.error)),
        "PENUMBRA_UNSUPPORTED: there are more than 65535 assets");
    EXPECT_EQ(penumbra_shading_create(x.asset.get(), nullptr, 0, nullptr, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(made, nullptr);
    EXPECT_EQ(make(materials_only, {PENUMBRA_SLICES, PENUMBRA_ROTATION, 8}), "PENUMBRA_OK: ");
    penumbra_shading_destroy(made);
    EXPECT_EQ(penumbra_character_create(nullptr, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_create(x.asset.get(), nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
}

TEST(CApiErrors, Switching) {
    const Whole x({}, {PENUMBRA_OPERATORS, PENUMBRA_ROTATION, 0}), lobes({}, {PENUMBRA_SLICES, PENUMBRA_LOBES, 0});
    penumbra_shading* s = x.shading.get();
    Said said;
    penumbra_error* e = &said.error;
    EXPECT_EQ(said.after(penumbra_shading_set_material(s, 0, 0, e)),
              "PENUMBRA_UNSUPPORTED: material 0 has no operators");
    EXPECT_EQ(said.after(penumbra_shading_set_material(s, 0, 2, e)),
              "PENUMBRA_INVALID_ARGUMENT: material is 2; there are 2");
    EXPECT_EQ(said.after(penumbra_shading_set_material(s, 2, 1, e)),
              "PENUMBRA_INVALID_ARGUMENT: slot is 2; there are 2");
    EXPECT_EQ(said.after(penumbra_shading_set_light(s, 2, e)), "PENUMBRA_INVALID_ARGUMENT: light is 2; there are 2");
    EXPECT_EQ(said.after(penumbra_shading_set_light(lobes.shading.get(), 0, e)),
              "PENUMBRA_UNSUPPORTED: light 0 has no lobes");
    std::vector<float> sh(3 * 64);
    EXPECT_THAT(said.after(penumbra_shading_set_sh_light(s, 1, sh.data(), 0, e)), HasSubstr("PENUMBRA_UNSUPPORTED"));
    const float stretched[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1.01f}, mirrored[9] = {1, 0, 0, 0, 1, 0, 0, 0, -1},
                broken[9] = {NAN, 0, 0, 0, 1, 0, 0, 0, 1}, zero[9] = {};
    for (const float* rotation : {stretched, mirrored, broken, zero})
        EXPECT_EQ(said.after(penumbra_shading_set_light_rotation(s, rotation, e)),
                  "PENUMBRA_INVALID_ARGUMENT: rotation is not orthonormal with determinant 1");
    EXPECT_EQ(penumbra_shading_set_light_rotation(s, nullptr, e), PENUMBRA_INVALID_ARGUMENT);
    const Whole roomy({}, {PENUMBRA_SLICES, PENUMBRA_ROTATION, 4});
    s = roomy.shading.get();
    EXPECT_THAT(said.after(penumbra_shading_set_sh_light(s, 5, sh.data(), 0, e)), HasSubstr("allowed are 1..4"));
    EXPECT_EQ(penumbra_shading_set_sh_light(s, 0, sh.data(), 0, e), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_set_sh_light(s, 4, nullptr, 0, e), PENUMBRA_INVALID_ARGUMENT);
    sh[47] = NAN;
    EXPECT_THAT(said.after(penumbra_shading_set_sh_light(s, 4, sh.data(), 0, e)), HasSubstr("sh[47] is not finite"));
    EXPECT_EQ(penumbra_shading_set_sh_light(s, 3, sh.data(), 0, e), PENUMBRA_OK);
    EXPECT_EQ(penumbra_shading_slot_count(nullptr), 0u);
    EXPECT_EQ(penumbra_shading_material_count(nullptr) + penumbra_shading_light_count(nullptr), 0u);
}

TEST(CApiErrors, ShadingArrays) {
    const Whole x;
    Frame frame(x.info);
    const penumbra_vertices good = frame.vertices();
    const penumbra_vertices too_many = frame.vertices(0, 31), beyond = frame.vertices(31, 0),
                            nobody = frame.vertices(30, 0);
    const auto shade = [&](const penumbra_vertices* vertices) {
        return penumbra_shading_shade(x.shading.get(), frame.eye, vertices, frame.radiance.data(), nullptr);
    };
    EXPECT_EQ(shade(&too_many), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(shade(&beyond), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(shade(nullptr), PENUMBRA_INVALID_ARGUMENT);
    for (const auto member : {&penumbra_vertices::positions, &penumbra_vertices::normals, &penumbra_vertices::tangents,
                              &penumbra_vertices::coefficients}) {
        penumbra_vertices bad = good;
        bad.*member = nullptr;
        EXPECT_EQ(shade(&bad), PENUMBRA_INVALID_ARGUMENT);
    }
    EXPECT_EQ(penumbra_shading_shade(x.shading.get(), frame.eye, &good, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_shade(x.shading.get(), nullptr, &good, frame.radiance.data(), nullptr),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_shade(nullptr, frame.eye, &good, frame.radiance.data(), nullptr),
              PENUMBRA_INVALID_ARGUMENT);
    for (const float wrong : {NAN, INFINITY, -INFINITY})
        for (int axis = 0; axis < 3; ++axis) {
            float eye[3] = {1, 2, 3};
            eye[axis] = wrong;
            Said said;
            const std::string expected = "PENUMBRA_INVALID_ARGUMENT: eye[" + std::to_string(axis) + "] is not finite";
            EXPECT_EQ(
                said.after(penumbra_shading_shade(x.shading.get(), eye, &good, frame.radiance.data(), &said.error)),
                expected);
        }
    EXPECT_EQ(frame.radiance, Frame(x.info).radiance);
    EXPECT_EQ(shade(&nobody), PENUMBRA_OK);
}

// Which is why the arrays need not be searched for it.
TEST(CApiErrors, ANumberThatIsNotFiniteSpoilsItsVertexAlone) {
    Whole x;
    Frame sound(x.info);
    sound.evaluate(x.character.get(), x.info);
    for (const penumbra_simd simd : {PENUMBRA_SIMD_PORTABLE, PENUMBRA_SIMD_AVX2}) {
        if (!penumbra_has_simd(simd)) continue;
        ASSERT_EQ(penumbra_shading_set_simd(x.shading.get(), simd, nullptr), PENUMBRA_OK);
        ASSERT_EQ(sound.shade(x.shading.get(), 0, 30), 0);
        for (const auto array : {&Frame::positions, &Frame::normals, &Frame::tangents, &Frame::coefficients}) {
            Frame frame = sound;
            const std::size_t stride = (frame.*array).size() / 30;
            (frame.*array)[11 * stride + 1] = NAN;
            ASSERT_EQ(frame.shade(x.shading.get(), 0, 30), 0);
            std::copy_n(sound.radiance.begin() + 33, 3, frame.radiance.begin() + 33);
            EXPECT_EQ(frame.radiance, sound.radiance);
        }
    }
}

// Handles are given back in any order, even the asset first.
TEST(CApiErrors, AnyOrderOfGivingBack) {
    Whole x;
    x.asset.reset();
    Frame frame(x.info);
    EXPECT_EQ(penumbra_character_set_frame(x.character.get(), 3, nullptr), PENUMBRA_OK);
    EXPECT_EQ(frame.evaluate(x.character.get(), x.info), PENUMBRA_OK);
    x.character.reset();
    EXPECT_EQ(frame.shade(x.shading.get(), 0, x.info.vertex_count), PENUMBRA_OK);
    penumbra_asset_close(nullptr);
    penumbra_character_destroy(nullptr);
    penumbra_shading_destroy(nullptr);
}

}  // namespace
}  // namespace penumbra::test_errors
