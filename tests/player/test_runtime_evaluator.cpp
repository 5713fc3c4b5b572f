#include <gtest/gtest.h>

#include <cstdlib>

#include "formats/parallel_for.h"
#include "pack/pack_asset.h"
#include "pack/quantize.h"
#include "player/runtime/evaluator.h"
#include "tests/player/count_allocations.h"
#include "tests/synthetic_model.h"

namespace penumbra {
namespace {

using synthetic::tubeModel;
using synthetic::TubeOptions;

Packed pack(const Model& model, AssetPrecision precision) {
    return packAsset(model, {}, {}, {.precision = precision, .max_error = {}}, "{}", 1);
}

// --- The formulas of formats/model_file.h in double precision, plainly ----------------------------------------------

std::vector<double> referenceFeatures(const Model& model, std::size_t frame, int joint) {
    const std::size_t joints = model.skin.jointCount();
    if (model.features == FeatureKind::kJointAngles)
        return {model.pose.begin() + long(frame) * model.pose_size,
                model.pose.begin() + long(frame + 1) * model.pose_size};
    std::vector<double> features;
    const auto bone = [&](std::size_t j) { return model.bones[frame * joints + j]; };
    const auto linear = [&](std::size_t j) {
        Mat3d m;
        for (int e = 0; e < 9; ++e) m.m[e] = bone(j).linear().m[e];
        return m;
    };
    const std::size_t c = std::size_t(joint);
    const Mat3d cofactors = cofactor(linear(c));
    const double determinant = dot(Vec3d{linear(c)(0, 0), linear(c)(0, 1), linear(c)(0, 2)},
                                   Vec3d{cofactors(0, 0), cofactors(0, 1), cofactors(0, 2)});
    const Mat3 own = nearestRotation(bone(c).linear());
    for (std::size_t j = 0; j < joints; ++j) {
        if (j == c) continue;
        const Vec3d centre = toDouble(model.joint_centers[j]);
        const Vec3d moved = linear(j) * centre + toDouble(bone(j).translation()) - toDouble(bone(c).translation());
        const Vec3d seen = transposed(cofactors) * moved / determinant - centre;
        const Mat3 turned = transposed(own) * nearestRotation(bone(j).linear());
        for (int i = 0; i < 3; ++i) features.push_back(seen[i] / model.feature_scale);
        for (int i = 0; i < 9; ++i) features.push_back(turned.m[std::size_t(i)] - (i % 4 == 0));
    }
    return features;
}

// [V, n] in the order of the model's own vertices.
std::vector<double> referenceNumbers(const Model& model, std::size_t frame) {
    const std::size_t size = std::size_t(model.convention.size());
    std::vector<double> numbers(model.mesh.vertexCount() * size);
    for (const ClusterModel& cluster : model.clusters) {
        const std::vector<double> raw = referenceFeatures(model, frame, cluster.joint);
        const std::size_t features = raw.size(), inputs = std::size_t(cluster.inputs());
        std::vector<double> x(inputs), y(cluster.bias.begin(), cluster.bias.end());
        for (std::size_t i = 0; i < inputs; ++i)
            for (std::size_t n = 0; n < features; ++n)
                x[i] += double(cluster.input_basis[i * features + n]) * (raw[n] - cluster.feature_mean[n]);
        for (std::size_t k = 0; k < y.size(); ++k)
            for (std::size_t i = 0; i < inputs; ++i) y[k] += double(cluster.weights[k * inputs + i]) * x[i];
        const std::size_t row = cluster.vertices.size() * size;
        for (std::size_t v = 0; v < cluster.vertices.size(); ++v)
            for (std::size_t i = 0; i < size; ++i) {
                double sum = cluster.mean[v * size + i];
                for (std::size_t k = 0; k < y.size(); ++k) sum += y[k] * cluster.basis[k * row + v * size + i];
                numbers[cluster.vertices[v] * size + i] = sum;
            }
    }
    return numbers;
}

std::vector<float> evaluate(Evaluator& evaluator, std::size_t frame) {
    const AssetView& asset = evaluator.asset();
    std::vector<float> numbers(evaluator.vertexCount() * std::size_t(asset.model.stride), -7.0f);
    evaluator.setPose(asset.animation.bonesOf(frame), asset.animation.poseOf(frame));
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateCluster(c, numbers);
    return numbers;
}

double largestDifference(const std::vector<float>& a, const std::vector<float>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(double(a[i]) - b[i]));
    return largest;
}

// --- Tests ----------------------------------------------------------------------------------------------------------

// Numbers reach 4. Measured: 3.7e-7; three times as much is allowed.
TEST(Evaluator, MatchesTheFormulasInDoublePrecision) {
    double largest = 0;
    for (const char* convention : {"A4", "B3", "D4", "D5", "A8"})
        for (FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kJointAngles}) {
            const Model model = tubeModel({.joints = 5,
                                           .clusters = 3,
                                           .components = 4,
                                           .inputs = 6,
                                           .convention = parseConvention(convention),
                                           .features = features});
            const Packed packed = pack(model, AssetPrecision::kF32);
            const AssetView asset = openAsset(packed.bytes);
            Evaluator evaluator(asset);
            const std::size_t size = std::size_t(model.convention.size()), stride = std::size_t(asset.model.stride);
            for (std::size_t f = 0; f < model.frames.frameCount(); ++f) {
                const std::vector<float> numbers = evaluate(evaluator, f);
                const std::vector<double> expected = referenceNumbers(model, f);
                for (std::size_t v = 0; v < evaluator.vertexCount(); ++v)
                    for (std::size_t i = 0; i < stride; ++i) {
                        const double e = i < size ? expected[asset.mesh.shading_point[v] * size + i] : 0;
                        largest = std::max(largest, std::abs(numbers[v * stride + i] - e));
                    }
            }
        }
    EXPECT_LT(largest, 1.2e-6);
}

// Also clusters whose count of numbers is no multiple of a register or of a tile. Measured: 2.4e-7 (fused or not).
TEST(Evaluator, EveryPathAgreesWithThePortableOne) {
    for (int segments : {1, 3, 7, 37})
        for (AssetPrecision precision : {AssetPrecision::kF32, AssetPrecision::kF16, AssetPrecision::kI8}) {
            const Model model = tubeModel({.rings = 9,
                                           .segments = segments,
                                           .clusters = 4,
                                           .components = 9,
                                           .convention = parseConvention(segments == 3 ? "D4" : "D5")});
            const Packed packed = pack(model, precision);
            const AssetView asset = openAsset(packed.bytes);
            Evaluator evaluator(asset);
            const std::vector<EvaluatorPath> paths = evaluatorPaths();
            evaluator.usePath(paths.front());
            const std::vector<float> expected = evaluate(evaluator, 1);
            for (const EvaluatorPath& path : paths) {
                evaluator.usePath(path);
                EXPECT_LT(largestDifference(evaluate(evaluator, 1), expected), 1e-6)
                    << path.name << " " << nameOf(precision) << " segments " << segments;
            }
        }
}

TEST(Evaluator, NoSimdInTheEnvironmentLeavesThePortablePath) {
    ::setenv("PENUMBRA_NO_SIMD", "1", 1);
    EXPECT_EQ(evaluatorPaths().size(), 1u);
    EXPECT_STREQ(evaluatorPaths()[0].name, "portable");
    ::unsetenv("PENUMBRA_NO_SIMD");
}

TEST(Evaluator, AllocatesNothing) {
    const Packed packed = pack(tubeModel({.clusters = 4}), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount();
    std::vector<float> numbers(count * std::size_t(asset.model.stride));
    std::vector<Vec3> positions(count), normals(count), tangents(count);
    const std::size_t before = allocationCount();
    evaluator.setPose(asset.animation.bonesOf(0), asset.animation.poseOf(0));
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateCluster(c, numbers);
    evaluator.skin(0, count, positions, normals, tangents);
    EXPECT_EQ(allocationCount() - before, 0u);
    const std::vector<int> proof(3);
    EXPECT_EQ(allocationCount() - before, 1u) << "the counter does not count";
}

TEST(Evaluator, SameNumbersForAnyThreadCount) {
    const Packed packed = pack(tubeModel({.rings = 40, .segments = 30, .clusters = 16}), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::vector<float> expected = evaluate(evaluator, 2);
    for (int threads : {2, 8}) {
        std::vector<float> numbers(expected.size());
        parallelFor(evaluator.clusterCount(), threads, [&](std::size_t c) { evaluator.evaluateCluster(c, numbers); });
        EXPECT_EQ(numbers, expected);
    }
}

// The evaluator blends in the same precision and order as skinVertices. Measured: 1.2e-7; positions are about 1.
TEST(Evaluator, SkinsAsTheBakeDoes) {
    const Model model = tubeModel({.clusters = 3});
    const Packed packed = pack(model, AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount(), joints = model.skin.jointCount();
    std::vector<Vec3> positions(count), normals(count), tangents(count), expected_positions, expected_normals;
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f) {
        const std::vector<Affine> bones(model.bones.begin() + long(f * joints),
                                        model.bones.begin() + long((f + 1) * joints));
        evaluator.setPose(bones, {});
        evaluator.skin(0, count / 2 + 1, positions, normals, tangents);  // a range may start inside a cluster
        evaluator.skin(count / 2 + 1, count, positions, normals, tangents);
        skinVertices(model.mesh, model.skin, model.rest_normals, bones, expected_positions, expected_normals);
        for (std::size_t v = 0; v < count; ++v) {
            const std::uint32_t old = asset.mesh.shading_point[v];
            EXPECT_LT(length(positions[v] - expected_positions[old]), 1e-6f);
            EXPECT_LT(length(normals[v] - expected_normals[old]), 1e-6f);
            EXPECT_NEAR(length(tangents[v]), 1, 1e-6);
            EXPECT_NEAR(dot(tangents[v], normals[v]), 0, 1e-6);
            const std::size_t cluster = model.cluster_of_vertex[old];
            const Vec3 carried = evaluator.clusterRotation(cluster) * model.rest_tangents[old];
            const Vec3 projected = normalized(carried - normals[v] * dot(carried, normals[v]));
            EXPECT_LT(length(tangents[v] - projected), 1e-5f);
        }
    }
}

TEST(Evaluator, TangentAlongTheNormalBecomesSomeOrthogonalOne) {
    Model model = tubeModel();
    model.rest_tangents = model.rest_normals;
    for (Affine& bone : model.bones) bone = {};
    const Packed packed = pack(model, AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount();
    std::vector<Vec3> positions(count), normals(count), tangents(count);
    evaluator.setPose(asset.animation.bonesOf(0), {});
    evaluator.skin(0, count, positions, normals, tangents);
    for (std::size_t v = 0; v < count; ++v) {
        EXPECT_NEAR(length(tangents[v]), 1, 1e-6);
        EXPECT_NEAR(dot(tangents[v], normals[v]), 0, 1e-6);
    }
}

// A bone scaled to nothing has no inverse: the numbers are what they are, but finite.
TEST(Evaluator, SingularBoneGivesFiniteNumbers) {
    Model model = tubeModel();
    for (std::size_t j = 0; j < model.skin.jointCount(); ++j) model.bones[j].m.fill(0);
    const Packed packed = pack(model, AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    for (float number : evaluate(evaluator, 0)) ASSERT_TRUE(std::isfinite(number));
}

}  // namespace
}  // namespace penumbra
