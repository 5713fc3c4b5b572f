// Checks of composed assets: where their error comes from.
#include <gtest/gtest.h>
#include <unistd.h>

#include "pack/check/check_asset.h"
#include "pack/check/error_budget.h"
#include "pack/compress/compress_model.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_check_composed {
namespace {

namespace fs = std::filesystem;

Model nearTube(std::size_t near_count) {
    Model model = synthetic::composedTube({.joints = 6, .frames = 6});
    if (near_count > 0) synthetic::addNearParts(model, near_count);
    return model;
}

// A bake whose visibility is what the model says, with the local moments that the model's local part says. The even
// moments of the local frames are half the numbers of D5; the odd ones, which nothing reads, are 0.
struct ComposedBake {
    Model model;
    Packed packed;
    AssetView asset;
    fs::path path = fs::temp_directory_path() / ("composed" + std::to_string(::getpid()) + ".vis.h5");

    explicit ComposedBake(int local_steps, std::size_t near_count = 0)
        : model(nearTube(near_count)),
          packed(packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1)),
          asset(openAsset(packed.bytes)) {
        VisibilityHeader header;
        header.rays = 16;
        if (local_steps > 0) header.local = LocalMoments{5, local_steps};
        header.mesh = model.mesh;
        header.skin = model.skin;
        header.rest_normals = model.rest_normals;
        header.frames = model.frames;
        header.pose_size = model.pose_size;
        header.provenance = model.provenance;
        VisibilityWriter writer(path, header, Precision::kFloat32);
        for (std::size_t f = 0; f < model.frames.frameCount(); ++f) writer.writeFrame(frame(f, local_steps > 0));
        writer.finish();
    }
    ~ComposedBake() { fs::remove(path); }

    VisibilityFrame frame(std::size_t f, bool with_local) const {
        Evaluator evaluator(asset);
        const std::size_t count = evaluator.vertexCount(), joints = model.skin.jointCount();
        std::vector<float> numbers(count * 16), local(count * 16);
        std::vector<Vec3> positions(count), normals(count), tangents(count);
        evaluator.setFrame(f);
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) {
            evaluator.evaluateCluster(c, numbers);
            evaluator.evaluateLocal(c, local);
        }
        evaluator.skin(0, count, positions, normals, tangents);
        VisibilityFrame out;
        out.positions.resize(count);
        out.normals.resize(count);
        out.bones.assign(model.bones.begin() + long(f * joints), model.bones.begin() + long((f + 1) * joints));
        out.pose.assign(model.pose.begin() + long(f) * model.pose_size,
                        model.pose.begin() + long(f + 1) * model.pose_size);
        out.coefficients.resize(count * 25);
        if (with_local) out.local_coefficients.resize(count * 25);
        for (std::size_t v = 0; v < count; ++v) {
            const std::size_t point = asset.mesh.shading_point[v];
            out.positions[point] = positions[v];
            out.normals[point] = normals[v];
            const ShRotation to_local = makeShRotation(5, toLocalFrame(normals[v], tangents[v]));
            const auto store = [&](const std::vector<float>& from, std::vector<float>& to) {
                std::vector<float> moments(25);
                for (std::size_t i = 0; i < 15; ++i)
                    moments[std::size_t(model.convention.indices()[i])] = from[v * 16 + i] / 2;
                applyTransposed(to_local, moments, std::span(to).subspan(point * 25, 25));
            };
            store(numbers, out.coefficients);
            if (with_local) store(local, out.local_coefficients);
        }
        return out;
    }

    ErrorFigures check(const AssetView& checked, const CheckReferences& references = {}) const {
        return checkAsset(checked, VisibilityReader(path), references, 2, [](std::size_t) {}).training;
    }
};

// Measured: 3e-6, from single-precision rotations there and back.
TEST(CheckComposed, AModelThatMadeTheTruthHasNoErrorOfItsOwn) {
    const ComposedBake bake(1);
    const ErrorFigures figures = bake.check(bake.asset);
    EXPECT_TRUE(figures.composed);
    EXPECT_LT(figures.relative_error, 1e-5);
    for (double local : {figures.local, figures.local_truncation, figures.local_regression}) EXPECT_LT(local, 1e-5);
    EXPECT_GT(figures.split, 0.01) << "the residual is not in it";
    EXPECT_NEAR(figures.split, figures.without_residual, 1e-5);
    EXPECT_TRUE(std::isnan(figures.truncation));
    EXPECT_TRUE(std::isnan(figures.regression));
}

// A row with the truth's local numbers is the same whether the model has near parts or not. This bake's local numbers
// lack what near parts hide, unlike those of penumbra-bake, so that the local model differs by it.
TEST(CheckComposed, TrueLocalNumbersAreNotMultipliedByNearParts) {
    const ComposedBake bake(1, 2);
    const ErrorFigures figures = bake.check(bake.asset);
    EXPECT_LT(figures.relative_error, 1e-5);
    Model without = bake.model;
    without.composition->near_count = 0;
    without.composition->near_parts.clear();
    without.composition->near_gains.clear();
    const Packed packed = packAsset(without, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    const ErrorFigures far_alone = bake.check(openAsset(packed.bytes));
    EXPECT_NEAR(figures.split, far_alone.split, 1e-6);
    EXPECT_GT(figures.local, 0.01) << "what near parts hide";
    EXPECT_LT(far_alone.local, 1e-5);
    EXPECT_TRUE(std::isnan(figures.local_truncation) && std::isnan(figures.local_regression));
    for (const BudgetRow& row : errorBudget(figures))
        if (row.name == "local PCA") {
            EXPECT_EQ(row.option, "a model without near parts");
        }
}

TEST(CheckComposed, NeedsLocalMomentsOfTheSameSteps) {
    for (int steps : {0, 2}) {
        const ComposedBake bake(steps);
        const ErrorFigures figures = bake.check(bake.asset);
        EXPECT_TRUE(std::isnan(figures.split));
        for (double local : {figures.local, figures.local_truncation, figures.local_regression})
            EXPECT_TRUE(std::isnan(local));
        EXPECT_GT(figures.without_residual, 0.01);
    }
}

TEST(CheckComposed, BudgetHasTheRowsOfAComposedModel) {
    const ComposedBake bake(1);
    const Packed bytes = packAsset(bake.model, {}, {}, {.precision = AssetPrecision::kI8}, "{}", 1);
    const AssetView small = openAsset(bytes.bytes);
    const ErrorFigures figures = bake.check(small, {.unpacked = &bake.asset});
    EXPECT_GT(figures.packing, 1e-3);
    EXPECT_NEAR(figures.packing, figures.relative_error, 1e-5) << "the truth is the unpacked model";
    for (double local : {figures.local, figures.local_truncation, figures.local_regression})
        EXPECT_LT(local, 1e-5) << "these are of the unpacked model, not of the packed one";
    const ErrorFigures stored = bake.check(small);
    for (double local : {stored.local, stored.local_truncation, stored.local_regression}) EXPECT_GT(local, 1e-4);
    std::vector<std::string> names;
    for (const BudgetRow& row : errorBudget(figures)) names.push_back(row.name);
    EXPECT_EQ(names, (std::vector<std::string>{"bake noise", "SH truncation", "true local x far", "local PCA",
                                               "local regression", "local model", "without residual", "unpacked model",
                                               "rank and quantisation", "total", "against all bands"}));
}

// The components still span the truth, so that whatever other scores cost is regression.
TEST(CheckComposed, OtherScoresAreLocalRegression) {
    const ComposedBake bake(1);
    Model other = bake.model;
    for (ClusterModel& cluster : other.clusters)
        for (float& x : cluster.bias) x += 0.1f;
    const Packed bytes = packAsset(other, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    const ErrorFigures figures = bake.check(openAsset(bytes.bytes));
    EXPECT_GT(figures.local, 0.01);
    EXPECT_LT(figures.local_truncation, 1e-5);
    EXPECT_NEAR(figures.local_regression, figures.local, 1e-5);
}

// Without components the model and the projected truth are both the mean, and nothing is left to regress.
TEST(CheckComposed, MissingComponentsAreLocalPca) {
    const ComposedBake bake(1);
    Model other = bake.model;
    for (ClusterModel& cluster : other.clusters) keepComponents(cluster, 0);
    const Packed bytes = packAsset(other, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    const ErrorFigures figures = bake.check(openAsset(bytes.bytes));
    EXPECT_GT(figures.local, 0.01);
    EXPECT_EQ(figures.local_regression, 0);
    EXPECT_EQ(figures.local_truncation, figures.local);
}

}  // namespace
}  // namespace penumbra::test_check_composed
