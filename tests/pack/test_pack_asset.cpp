#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/compress/quantize.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "sh/brdf/slice_form.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_pack_asset {
namespace {

using synthetic::tubeModel;

std::vector<float> decoded(const NumbersView& coefficients) {
    std::vector<float> values(coefficients.count);
    decode(coefficients, values);
    return values;
}

TEST(Quantize, EveryPrecisionStaysWithinItsBound) {
    synthetic::Noise noise(1);
    std::vector<float> values;
    synthetic::fillNoise(values, 600, 3, noise);
    for (std::size_t i = 200; i < 400; ++i) values[i] *= 1e-3f;  // the second row is small: it has its own scale
    values[7] = 1e-7f;
    const StoredNumbers f32 = quantize(values, 200, AssetPrecision::kF32, "x");
    EXPECT_EQ(decoded(f32.view()), values);
    const std::vector<float> f16 = decoded(quantize(values, 200, AssetPrecision::kF16, "x").view());
    const StoredNumbers i8 = quantize(values, 200, AssetPrecision::kI8, "x");
    ASSERT_EQ(i8.scale.size(), 3u);
    for (std::size_t row = 0; row < 3; ++row) {
        const auto [low, high] =
            std::minmax_element(values.begin() + long(200 * row), values.begin() + long(200 * row + 200));
        EXPECT_FLOAT_EQ(i8.scale[row], std::max(-*low, *high) / 127) << "the largest number takes the largest byte";
    }
    const std::vector<float> bytes = decoded(i8.view());
    for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_LE(std::abs(f16[i] - values[i]), std::max(std::abs(values[i]) * 0x1p-11f, 0x1p-25f));
        EXPECT_LE(std::abs(bytes[i] - values[i]), i8.scale[i / 200] * 0.5001f);
    }
}

TEST(Quantize, RowsOfZerosAndOfNextToNothingBecomeZeros) {
    const std::vector<float> values = {0, 0, 0, 0, 1e-40f, -1e-40f, 0, 1e-42f};
    for (float v : decoded(quantize(values, 4, AssetPrecision::kI8, "x").view())) EXPECT_NEAR(v, 0, 2e-40);
}

TEST(Quantize, RefusesWhatThePrecisionCannotHold) {
    const std::vector<float> large = {1, 70000}, bad = {1, NAN};
    EXPECT_THROW(quantize(large, 2, AssetPrecision::kF16, "x"), InvalidInput);
    EXPECT_NO_THROW(quantize(large, 2, AssetPrecision::kI8, "x"));
    for (AssetPrecision p : {AssetPrecision::kF32, AssetPrecision::kF16, AssetPrecision::kI8})
        EXPECT_THROW(quantize(bad, 2, p, "x"), InvalidInput);
}

TEST(PackAsset, MakesEveryClusterAContiguousRange) {
    const Model model = tubeModel({.clusters = 4});
    const Packed packed = packAsset(model, {}, {}, {}, "{}", 1);
    const AssetView asset = openAsset(packed.bytes);
    std::size_t v = 0;
    for (std::size_t c = 0; c < model.clusters.size(); ++c)
        for (std::uint32_t old : model.clusters[c].vertices) {
            ASSERT_EQ(asset.mesh.shading_point[v], old);
            EXPECT_EQ(asset.mesh.positions[v], model.mesh.rest_positions[old]);
            EXPECT_EQ(asset.mesh.normals[v], model.rest_normals[old]);
            EXPECT_EQ(asset.mesh.skin_joints[2 * v + 1], model.skin.joints[2 * old + 1]);
            EXPECT_EQ(asset.mesh.skin_weights[2 * v + 1], model.skin.weights[2 * old + 1]);
            ++v;
        }
    EXPECT_EQ(v, model.mesh.vertexCount());
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_EQ(asset.mesh.shading_point[asset.mesh.triangles[3 * t + i]], model.mesh.triangles[t][i]);
    for (std::size_t r = 0; r < model.mesh.source_vertex.size(); ++r)
        EXPECT_EQ(asset.mesh.shading_point[asset.mesh.source_vertex[r]], model.mesh.source_vertex[r]);
}

// |error of a number| <= |error of its mean| + sum_k |y_k| scale_k / 2, whatever the pose. The stored error is the one
// that the evaluator shows.
TEST(PackAsset, QuantisationErrorIsBoundedAndMeasured) {
    const Model model = tubeModel({.rings = 12, .segments = 9, .components = 6, .frames = 8});
    const PackOptions f32{.precision = AssetPrecision::kF32};
    const Packed exact = packAsset(model, {}, {}, f32, "{}", 1),
                 packed = packAsset(model, {}, {}, {.precision = AssetPrecision::kI8}, "{}", 2);
    EXPECT_EQ(packed.components, packed.all_components);
    const AssetView a = openAsset(packed.bytes), b = openAsset(exact.bytes);
    EXPECT_EQ(b.model.quantization_error, 0);
    Evaluator coarse(a), fine(b);
    std::vector<float> x(coarse.vertexCount() * std::size_t(a.model.stride)), y(x.size());
    double difference = 0, variation = 0;
    for (std::size_t f = 0; f < a.animation.frameCount(); ++f) {
        coarse.setPose(a.animation.bonesOf(f), {});
        fine.setPose(b.animation.bonesOf(f), {});
        for (std::size_t c = 0; c < coarse.clusterCount(); ++c) {
            coarse.evaluateCluster(c, x);
            fine.evaluateCluster(c, y);
            const ClusterView& cluster = a.model.clusters[c];
            double bound = 4 * 0x1p-11 + 1e-3;  // the mean reaches 4; scores differ a little: half-precision inputs
            for (std::size_t k = 0; k < cluster.components(); ++k)
                bound += std::abs(coarse.scores(c)[k]) * cluster.basis.scale[k] / 2;
            const std::vector<float> mean = decoded(b.model.clusters[c].mean);
            const std::size_t first = cluster.first_vertex * std::size_t(a.model.stride);
            for (std::size_t i = 0; i < mean.size(); ++i) {
                ASSERT_LE(std::abs(x[first + i] - y[first + i]), bound);
                if (f >= 4) continue;  // the held-out clip is bounded, but not part of the measure
                difference += std::pow(double(x[first + i]) - y[first + i], 2);
                variation += std::pow(double(y[first + i]) - mean[i], 2);
            }
        }
    }
    EXPECT_NEAR(packed.quantization_error, std::sqrt(difference / variation), 1e-12);
    EXPECT_FLOAT_EQ(a.model.quantization_error, float(packed.quantization_error));
    EXPECT_GT(packed.quantization_error, 1e-4);
    EXPECT_LT(packed.quantization_error, 2e-2);
}

TEST(PackAsset, MaxErrorTakesTheCoarsestPrecisionWithinIt) {
    Model model = tubeModel({.rings = 12, .segments = 9, .components = 6, .frames = 8});
    synthetic::turnJointsApart(model);
    for (ClusterModel& cluster : model.clusters)  // a signal that the rounding of the mean is small against
        for (float& weight : cluster.weights) weight *= 10;
    const auto pack = [&](double bound) { return packAsset(model, {}, {}, {.max_error = bound}, "{}", 1); };
    const auto whole = [&](AssetPrecision precision) {
        return packAsset(model, {}, {}, {.precision = precision}, "{}", 1).quantization_error;
    };
    const double i8 = whole(AssetPrecision::kI8), f16 = whole(AssetPrecision::kF16);
    ASSERT_LT(3 * f16, i8);
    // Components along principal axes round a little better or worse than the model's own.
    EXPECT_EQ(pack(i8 * 1.5).precision, AssetPrecision::kI8);
    EXPECT_EQ(pack(f16 * 1.5).precision, AssetPrecision::kF16);
    EXPECT_EQ(pack(f16 * 0.5).precision, AssetPrecision::kF32);
    for (double bound : {i8 * 1.5, f16 * 1.5, f16 * 0.5}) EXPECT_LE(pack(bound).quantization_error, bound);
    const PackOptions too_coarse{.precision = AssetPrecision::kI8, .max_error = f16 * 1.5};
    EXPECT_THROW(packAsset(model, {}, {}, too_coarse, "{}", 1), UsageError);
}

TEST(PackAsset, SameBytesForAnyThreadCount) {
    const Model model = tubeModel({.rings = 20, .segments = 12, .clusters = 7});
    const std::vector<std::byte> expected = packAsset(model, {}, {}, {}, "{}", 1).bytes;
    for (int threads : {2, 8}) EXPECT_EQ(packAsset(model, {}, {}, {}, "{}", threads).bytes, expected);
}

TEST(PackAsset, OneSliceSetWhereChannelsDifferByAFactorOnly) {
    BrdfFile tinted = synthetic::lambert({0.2, 0.8, 0.0}), mixed = synthetic::lambert();
    tinted.name = "tinted";
    mixed.slices[4] += 0.1;  // one entry of the green channel
    const std::vector<BrdfFile> brdfs = {tinted, mixed};
    const Packed packed = packAsset(tubeModel(), brdfs, {}, {}, "{}", 1);
    const AssetView asset = openAsset(packed.bytes);
    ASSERT_EQ(asset.materials.size(), 2u);
    EXPECT_EQ(asset.materials[0].channels, 1);
    EXPECT_EQ(asset.materials[1].channels, 3);
    const std::size_t count = tinted.slices.size() / 3;
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(asset.materials[0].slices[i] * asset.materials[0].color[int(c)], tinted.slices[3 * i + c],
                        1e-7);
            EXPECT_FLOAT_EQ(asset.materials[1].slices[c * count + i], float(mixed.slices[3 * i + c]));
        }
}

BrdfFile withOperators(Vec3d color) {
    BrdfFile brdf = synthetic::lambert(color);
    brdf.operators = {2, 3, {}, brdf.even_index, {}, "table"};
    for (int i = 0; i < 2 * 9; ++i)
        for (int c = 0; c < 3; ++c) brdf.operators.u.push_back(color[c] * (i + 1));
    for (std::size_t i = 0; i < 2 * brdf.even_index.size() * 3; ++i) brdf.operators.w.push_back(double(i / 3) - 7);
    return brdf;
}

TEST(PackAsset, KeepsOperators) {
    BrdfFile one = withOperators({0.2, 0.8, 0.0}), three = withOperators({1, 1, 1});
    three.name = "three";
    three.operators.u[4] = -1;  // one channel differs, though the slices do not
    const std::vector<BrdfFile> brdfs = {one, three};
    const Packed packed = packAsset(tubeModel({.clusters = 2}), brdfs, {}, {}, "{}", 1);
    const AssetView asset = openAsset(packed.bytes);
    const std::size_t even = one.even_index.size();
    for (std::size_t material = 0; material < 2; ++material) {
        const MaterialView& view = asset.materials[material];
        const BrdfOperators& stored = brdfs[material].operators;
        ASSERT_EQ(view.channels, material == 0 ? 1 : 3);
        ASSERT_EQ(view.operators.count, 2);
        ASSERT_EQ(view.operators.order, 3);
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t set = view.channels == 1 ? 0 : c;
            for (std::size_t i = 0; i < 18; ++i)
                EXPECT_NEAR(view.operators.u[set * 18 + i] * view.color[int(c)], stored.u[i * 3 + c], 1e-5);
            for (std::size_t i = 0; i < 2 * even; ++i)
                EXPECT_EQ(view.operators.w[set * 2 * even + i], stored.w[i * 3 + c]);
        }
    }
    EXPECT_EQ(
        openAsset(
            packAsset(tubeModel({.clusters = 2}), std::vector<BrdfFile>{synthetic::lambert()}, {}, {}, "{}", 1).bytes)
            .materials[0]
            .operators.count,
        0);
}

TEST(PackAsset, RefusesOperatorsThatNoPlayerReads) {
    BrdfFile brdf = withOperators({1, 1, 1});
    brdf.operators.source = "literal";
    brdf.operators.view_index = {0, 1, 2};
    brdf.operators.w.resize(2 * 3 * 3);
    EXPECT_THROW(packAsset(tubeModel({.clusters = 2}), std::vector<BrdfFile>{brdf}, {}, {}, "{}", 1), Unsupported);
}

BrdfFile plainMaterial(const std::string& name) {
    BrdfFile brdf;
    brdf.name = name;
    brdf.slice_order = 1;
    brdf.view_order = 1;
    brdf.even_index = {0};
    brdf.slices = {1, 1, 1};
    brdf.lobes = {lobeOf({})};
    return brdf;
}

TEST(PackAsset, SlotsFollowTheirVerticesAndGetTheirMaterials) {
    Model model = tubeModel({.clusters = 4});
    model.mesh.slots = {"body/skin", "body/cloth", "sword/steel"};
    for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v)
        model.mesh.slot_of_vertex.push_back(std::uint16_t(v % 3));
    const std::vector<BrdfFile> materials = {plainMaterial("lambert"), plainMaterial("ggx:alpha=0.3")};
    PackOptions options;
    const auto chosen = [&](std::vector<SlotChoice> slots) {
        options.slots = std::move(slots);
        const Packed packed = packAsset(model, materials, {}, options, "{}", 1);
        const AssetView asset = openAsset(packed.bytes);
        EXPECT_EQ(asset.mesh.slots.size(), 3u);
        for (std::size_t v = 0; v < asset.mesh.slot_of_vertex.size(); ++v)
            EXPECT_EQ(asset.mesh.slot_of_vertex[v], asset.mesh.shading_point[v] % 3);
        return asset.slot_material;
    };
    using Indices = std::vector<std::uint16_t>;
    EXPECT_EQ(chosen({}), (Indices{0, 0, 0}));
    EXPECT_EQ(chosen({{"steel", "ggx"}}), (Indices{0, 0, 1}));
    EXPECT_EQ(chosen({{"body", "ggx"}, {"body/skin", "lambert"}}), (Indices{0, 1, 0}));
    EXPECT_EQ(chosen({{"s", "ggx"}}), (Indices{1, 0, 1}));
    EXPECT_THROW(chosen({{"helmet", "ggx"}}), UsageError);
    EXPECT_THROW(chosen({{"body", "phong"}}), UsageError);
}

// Makes a material whose three channels differ, from random numbers of one form.
BrdfFile materialOfForm(SliceForm form) {
    BrdfFile brdf = synthetic::lambert();
    brdf.name = nameOf(form);
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    std::vector<float> entries(3 * entryCount(form, 5, 5));
    for (float& x : entries) x = normal(random);
    const std::vector<float> slices = expandSlices(form, 5, 5, entries);
    for (std::size_t i = 0; i < brdf.slices.size(); ++i) brdf.slices[i] = double(slices[i % 3 * 375 + i / 3]);
    return brdf;
}

std::size_t materialBytes(const AssetView& asset, std::size_t file_size) {
    for (const SizeOf& size : sectionSizes(asset, file_size))
        if (size.section == "materials") return size.bytes;
    return 0;
}

TEST(PackAsset, StoresSlicesInTheirMostCompactForm) {
    const Model model = tubeModel();
    const auto check = [&](const BrdfFile& brdf, SliceForm form, int channels, std::size_t bytes) {
        const Packed packed = packAsset(model, std::vector<BrdfFile>{brdf}, {}, {}, "{}", 1);
        const AssetView asset = openAsset(packed.bytes);
        const MaterialView& material = asset.materials[0];
        EXPECT_STREQ(nameOf(material.slice_form), nameOf(form));
        EXPECT_EQ(material.channels, channels);
        EXPECT_EQ(material.stored_slices.size_bytes(), bytes);
        EXPECT_EQ(materialBytes(asset, packed.bytes.size()), bytes + sizeof(BrdfLobe));
        ASSERT_EQ(material.slices.size(), std::size_t(channels) * 375);
        for (std::size_t i = 0; i < material.slices.size(); ++i)
            EXPECT_EQ(material.slices[i], float(brdf.slices[i % 375 * 3 + i / 375])) << i;
    };
    check(synthetic::lambert(), SliceForm::kIsotropic, 1, 128);
    check(materialOfForm(SliceForm::kIsotropic), SliceForm::kIsotropic, 3, 3 * 128);
    check(materialOfForm(SliceForm::kOrthotropic), SliceForm::kOrthotropic, 3, 3 * 408);
    check(materialOfForm(SliceForm::kGeneral), SliceForm::kGeneral, 3, 3 * 1500);
}

// The entries that the run time reads belong to the view, not to the file. They outlive moves and copies of it.
TEST(PackAsset, UnfoldedSlicesSurviveCopiesOfTheView) {
    const BrdfFile brdf = materialOfForm(SliceForm::kOrthotropic);
    const std::vector<std::byte> bytes =
        packAsset(tubeModel(), std::vector<BrdfFile>{brdf, synthetic::lambert()}, {}, {}, "{}", 1).bytes;
    std::optional<AssetView> first = openAsset(bytes);
    AssetView copy = *first;
    MaterialView alone = first->materials[0];
    const float* unfolded = alone.slices.data();
    AssetView moved = std::move(*first);
    first.reset();
    EXPECT_EQ(moved.materials[0].slices.data(), unfolded);
    moved = AssetView{};
    copy.materials.erase(copy.materials.begin());
    EXPECT_EQ(copy.materials[0].slices[0], float(synthetic::lambert().slices[0]));
    ASSERT_EQ(alone.slices.data(), unfolded);
    for (std::size_t i = 0; i < 375; ++i) EXPECT_EQ(alone.slices[i], float(brdf.slices[3 * i]));
}

TEST(PackAsset, RefusesMoreMaterialsThanAnAssetHolds) {
    const std::vector<BrdfFile> materials(kMaxMaterials + 1, plainMaterial("plain"));
    try {
        packAsset(tubeModel(), materials, {}, {}, "{}", 1);
        FAIL() << "accepted";
    } catch (const InvalidInput& error) {
        EXPECT_STREQ(error.what(), "4097 materials are given; an asset has 4096 at most");
    }
}

TEST(PackAsset, RefusesAMaterialOrALightTwice) {
    const std::vector<BrdfFile> brdfs(2, synthetic::lambert());
    const std::vector<LightFile> lights(2, synthetic::light(4, 0));
    EXPECT_THROW(packAsset(tubeModel(), brdfs, {}, {}, "{}", 1), InvalidInput);
    EXPECT_THROW(packAsset(tubeModel(), {}, lights, {}, "{}", 1), InvalidInput);
}

TEST(PackAsset, SectionSizesAddUpToTheFile) {
    const Packed packed = packAsset(tubeModel(), {}, {}, {}, "{}", 1);
    std::size_t sum = 0;
    for (const SizeOf& size : sectionSizes(openAsset(packed.bytes), packed.bytes.size())) sum += size.bytes;
    EXPECT_EQ(sum, packed.bytes.size());
}

// For teeth, say, visibility never changes. It has components of zeros and, in an additive model, no unit.
TEST(PackAsset, AClusterThatNeverChanges) {
    for (ModelKind kind : kModelKinds) {
        Model model = synthetic::tubeModel({.kind = kind});
        ClusterModel& still = model.clusters[1];
        std::fill(still.basis.begin(), still.basis.end(), 0.0f);
        if (kind == ModelKind::kAdditive) {
            still.hidden.clear();
            still.unit_group.clear();
            still.weights.clear();
        }
        const Packed packed = packAsset(model, {}, {}, {}, "{}", 1);
        EXPECT_GE(openAsset(packed.bytes).model.clusters[1].components(), 1u) << nameOf(kind);
    }
}

TEST(PackAsset, KeepsTheLobesOfALight) {
    std::vector<LightFile> lights = {synthetic::light(3, 0.3), synthetic::light(3, 0.4)};
    lights[1].name = "with lobes";
    lights[1].lobes = {"joint", {{0, 0, 1}, {0.6, -0.8, 0}}, {}, 0, 0};
    for (int i = 0; i < 2 * 3 * 3; ++i) lights[1].lobes.coefficients.push_back(std::sin(0.7 * i));
    const Packed packed = packAsset(tubeModel(), {}, lights, {}, "{}", 1);
    const AssetView asset = openAsset(packed.bytes);
    EXPECT_TRUE(asset.lights[0].lobes.directions.empty());
    const LobesView& lobes = asset.lights[1].lobes;
    ASSERT_EQ(lobes.directions.size(), 2u);
    EXPECT_EQ(lobes.directions[1], (Vec3{0.6f, -0.8f, 0}));
    ASSERT_EQ(lobes.coefficients.size(), 18u);
    for (std::size_t i = 0; i < 18; ++i) EXPECT_EQ(lobes.coefficients[i], float(lights[1].lobes.coefficients[i]));
}

TEST(PackLibrary, HoldsMaterialsAndLightsOnly) {
    const std::array materials = {synthetic::lambert({0.5, 0.2, 0.1})};
    const std::array lights = {synthetic::light(4, 0.1)};
    const std::vector<std::byte> bytes = packLibrary(materials, lights, "{}");
    const AssetView asset = openAsset(bytes);
    EXPECT_FALSE(asset.has_model || asset.has_mesh || asset.has_truth);
    ASSERT_EQ(asset.materials.size(), 1u);
    EXPECT_EQ(asset.materials[0].name, materials[0].name);
    ASSERT_EQ(asset.lights.size(), 1u);
    EXPECT_EQ(asset.lights[0].order, 4);
    EXPECT_NO_THROW(openAsset(packLibrary(materials, {}, "{}")));
    EXPECT_THROW(packLibrary({}, {}, "{}"), UsageError);
    const std::array twice = {materials[0], materials[0]};
    EXPECT_THROW(packLibrary(twice, {}, "{}"), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_pack_asset
