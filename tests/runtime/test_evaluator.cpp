#include <gtest/gtest.h>

#include "formats/common/parallel_for.h"
#include "pack/compress/quantize.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "tests/difference.h"
#include "tests/no_simd.h"
#include "tests/posed_vertices.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_evaluator {
namespace {

using synthetic::tubeModel;
using synthetic::TubeOptions;

Packed pack(const Model& model, AssetPrecision precision) {
    return packAsset(model, {}, {}, {.precision = precision, .max_error = {}}, "{}", 1);
}

// --- The formulas of formats/stage/model_file.h in double precision, plainly -----------------------------------------

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
        const Vec3d center = toDouble(model.joint_centers[j]);
        const Vec3d moved = linear(j) * center + toDouble(bone(j).translation()) - toDouble(bone(c).translation());
        const Vec3d seen = transposed(cofactors) * moved / determinant - center;
        const Mat3 turned = transposed(own) * nearestRotation(bone(j).linear());
        for (int i = 0; i < 3; ++i) features.push_back(seen[i] / model.feature_scale);
        for (int i = 0; i < 9; ++i) features.push_back(turned.m[std::size_t(i)] - (i % 4 == 0));
    }
    return features;
}

double clampedTo(double x, double least, double most) { return std::min(std::max(x, least), most); }

std::vector<double> referenceInputs(const ClusterModel& cluster, const std::vector<double>& raw) {
    std::vector<double> x(cluster.input_min.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        for (std::size_t n = 0; n < raw.size(); ++n)
            x[i] += double(cluster.input_basis[i * raw.size() + n]) * (raw[n] - cluster.feature_mean[n]);
        const double margin = kRangeMargin * (double(cluster.input_max[i]) - cluster.input_min[i]);
        x[i] = clampedTo(x[i], cluster.input_min[i] - margin, cluster.input_max[i] + margin);
    }
    return x;
}

// Returns the inputs of group g before they are clamped.
std::vector<double> referenceGroup(const Model& model, const ClusterModel& cluster, std::size_t g,
                                   const std::vector<double>& raw) {
    const std::size_t j = cluster.groups[g];
    if (model.features == FeatureKind::kJointAngles) return {raw[3 * j], raw[3 * j + 1], raw[3 * j + 2]};
    const double* bone = raw.data() + 12 * (int(j) > cluster.joint ? j - 1 : j);
    const Vec3d p = (toDouble(model.joint_centers[j]) - toDouble(cluster.center)) / model.feature_scale +
                    Vec3d{bone[0], bone[1], bone[2]};
    const double r = std::sqrt(dot(p, p) + 1e-4);
    std::vector<double> x{p.x / r, p.y / r, p.z / r, std::log(r)};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            double sum = 0;
            for (int k = 0; k < 3; ++k) sum += bone[3 + 3 * row + k] * double(model.joint_spreads[j](k, column));
            x.push_back(sum / r);
        }
    return x;
}

// Returns the units of an additive model. Adds to `out_of_range` what the ranges cut off, squared.
std::vector<double> referenceUnits(const Model& model, const ClusterModel& cluster, const std::vector<double>& raw,
                                   double& out_of_range) {
    std::vector<std::vector<double>> groups;
    for (std::size_t g = 0; g < cluster.groups.size(); ++g) {
        std::vector<double>& x = groups.emplace_back(referenceGroup(model, cluster, g, raw));
        for (std::size_t i = 0; i < x.size(); ++i) {
            const double inside =
                clampedTo(x[i], cluster.group_min[g * x.size() + i], cluster.group_max[g * x.size() + i]);
            out_of_range += cluster.group_weight[g] * (x[i] - inside) * (x[i] - inside);
            x[i] = inside;
        }
    }
    std::vector<double> units;
    for (std::size_t h = 0; h < cluster.unit_group.size(); ++h) {
        const std::vector<double>& x = groups[cluster.unit_group[h]];
        double squared = 0;
        for (std::size_t i = 0; i < x.size(); ++i) squared += std::pow(x[i] - cluster.hidden[h * x.size() + i], 2);
        units.push_back(std::exp(-squared / 2));
    }
    return units;
}

struct ReferencePose {
    std::vector<double> coefficients;  // [V, n] in the order of the model's own vertices
    double out_of_range = 0;
};

void addCluster(const Model& model, const ClusterModel& cluster, const std::vector<double>& raw, ReferencePose& pose) {
    double squared = 0;
    std::vector<double> units = referenceUnits(model, cluster, raw, squared);
    pose.out_of_range += squared * double(cluster.vertices.size());
    if (model.kind != ModelKind::kAdditive) units = referenceInputs(cluster, raw);
    const std::vector<double> x = units;
    if (model.kind == ModelKind::kQuadratic)
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t j = i; j < x.size(); ++j) units.push_back(x[i] * x[j]);
    if (model.kind == ModelKind::kNeural) {
        units.clear();
        for (std::size_t at = 0; at < cluster.hidden.size(); at += x.size() + 1) {
            double sum = cluster.hidden[at + x.size()];
            for (std::size_t i = 0; i < x.size(); ++i) sum += double(cluster.hidden[at + i]) * x[i];
            units.push_back(std::tanh(sum));
        }
    }
    std::vector<double> y(cluster.bias.begin(), cluster.bias.end());
    for (std::size_t k = 0; k < y.size(); ++k)
        for (std::size_t h = 0; h < units.size(); ++h) y[k] += double(cluster.weights[k * units.size() + h]) * units[h];
    const std::size_t size = std::size_t(model.convention.size()), row = cluster.vertices.size() * size;
    std::vector<float> ambient(size);
    ambientWeights(model.convention, ambient);
    for (std::size_t v = 0; v < cluster.vertices.size(); ++v) {
        double* out = pose.coefficients.data() + cluster.vertices[v] * size;
        double e = 0, norm2 = 0;
        for (std::size_t i = 0; i < size; ++i) {
            out[i] = cluster.mean[v * size + i];
            for (std::size_t k = 0; k < y.size(); ++k) out[i] += y[k] * cluster.basis[k * row + v * size + i];
            e += ambient[i] * out[i];
            norm2 += double(ambient[i]) * ambient[i];
        }
        for (std::size_t i = 0; i < size; ++i) out[i] -= ambient[i] * (e - clampedTo(e, 0, 1)) / norm2;
    }
}

ReferencePose referencePose(const Model& model, std::size_t frame) {
    ReferencePose pose;
    pose.coefficients.resize(model.mesh.vertexCount() * std::size_t(model.convention.size()));
    for (const ClusterModel& cluster : model.clusters)
        addCluster(model, cluster, referenceFeatures(model, frame, cluster.joint), pose);
    pose.out_of_range = std::sqrt(pose.out_of_range / double(model.mesh.vertexCount()));
    return pose;
}

std::vector<float> evaluate(Evaluator& evaluator, std::size_t frame) {
    const AssetView& asset = evaluator.asset();
    evaluator.setPose(asset.animation.bonesOf(frame), asset.animation.poseOf(frame));
    return coefficientsOf(evaluator);
}

// --- Tests ----------------------------------------------------------------------------------------------------------

// Returns the largest difference of a number and of the measure of range, over the frames.
std::pair<double, double> differenceToReference(const Model& model) {
    const Packed packed = pack(model, AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t size = std::size_t(model.convention.size()), stride = std::size_t(asset.model.stride);
    Largest numbers_off, range_off, range;
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f) {
        const ReferencePose expected = referencePose(model, f);
        for (const EvaluatorPath& path : evaluatorPaths()) {
            evaluator.usePath(path);
            const std::vector<float> coefficients = evaluate(evaluator, f);
            for (std::size_t v = 0; v < evaluator.vertexCount(); ++v)
                for (std::size_t i = 0; i < stride; ++i) {
                    const double e = i < size ? expected.coefficients[asset.mesh.shading_point[v] * size + i] : 0;
                    numbers_off.add(std::abs(coefficients[v * stride + i] - e));
                }
        }
        range_off.add(std::abs(evaluator.outOfRange() - expected.out_of_range));
        range.add(expected.out_of_range);
    }
    EXPECT_TRUE(range > 0.05 || model.features == FeatureKind::kJointAngles) << "nothing was clamped";
    return {numbers_off, range_off};
}

// Numbers reach 4. Measured: 7e-7 and 1e-7; about twice as much is allowed.
TEST(Evaluator, MatchesTheFormulasInDoublePrecision) {
    Largest coefficients, range;
    for (const char* convention : {"A4", "B3", "D4", "D5", "A8"})
        for (FeatureKind features : synthetic::kSkinnedFeatures)
            for (ModelKind kind : kModelKinds) {
                TubeOptions options{.joints = 5, .clusters = 3, .components = 4, .inputs = 6};
                options.convention = parseConvention(convention);
                options.features = features;
                options.kind = kind;
                const auto [numbers_off, range_off] = differenceToReference(tubeModel(options));
                coefficients.add(numbers_off);
                range.add(range_off);
            }
    EXPECT_LT(coefficients, 1.2e-6);
    EXPECT_LT(range, 2e-7);
}

// However wild the pose is, E of every vertex stays in [0, 1] and scores stay those of poses at the edge of training.
TEST(Evaluator, NoPoseMakesItExplode) {
    for (ModelKind kind : kModelKinds) {
        const Packed packed = pack(tubeModel({.joints = 5, .kind = kind}), AssetPrecision::kI8);
        const AssetView asset = openAsset(packed.bytes);
        Evaluator evaluator(asset);
        std::vector<float> coefficients(evaluator.vertexCount() * std::size_t(asset.model.stride));
        std::vector<float> e(evaluator.vertexCount());
        for (float size : {1.0f, 1e3f, 1e6f}) {
            std::vector<Affine> bones(5);
            for (std::size_t j = 0; j < bones.size(); ++j)
                for (std::size_t i = 0; i < 12; ++i) bones[j].m[i] = size * std::sin(float(7 * j + 3 * i) + size);
            evaluator.setPose(bones, {});
            EXPECT_GT(evaluator.outOfRange(), 0.1) << nameOf(kind);
            for (const EvaluatorPath& path : evaluatorPaths()) {
                evaluator.usePath(path);
                for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateCluster(c, coefficients);
                ambient(asset, coefficients, e);
                for (float value : e)
                    EXPECT_TRUE(value >= -1e-5f && value <= 1 + 1e-5f) << nameOf(kind) << " " << value;
                EXPECT_GT(largestOf(e), 0.3) << "not all is dark";
            }
        }
    }
}

// Includes clusters whose count of numbers is no multiple of a register or of a tile. Measured: 2.4e-7 (fused or
// not).
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

// E of some vertices is below 0 and of some above 1. Each moves along the weights until E is 0 or 1. Counts of vertices
// leave lanes over, and strides have a kernel of their own or not. Numbers reach 8, of which floats round 5e-7.
TEST(Evaluator, EveryPathClampsAmbientVisibility) {
    for (const char* name : {"D5", "D4", "B3", "A8"})
        for (const std::size_t vertices : {1u, 7u, 8u, 37u}) {
            const Convention convention = parseConvention(name);
            const std::size_t size = std::size_t(convention.size()), stride = (size + 3) / 4 * 4;
            std::vector<float> weights(stride), coefficients;
            ambientWeights(convention, std::span(weights).first(size));
            synthetic::Noise noise(5);
            synthetic::fillNoise(coefficients, vertices * stride, 8, noise);
            double norm2 = 0;
            for (const float w : weights) norm2 += double(w) * w;
            std::vector<float> expected = coefficients;
            std::size_t below = 0, above = 0;
            for (std::size_t v = 0; v < vertices; ++v) {
                double e = 0;
                for (std::size_t i = 0; i < stride; ++i) e += double(weights[i]) * coefficients[v * stride + i];
                below += e<0, above += e> 1;
                for (std::size_t i = 0; i < stride; ++i)
                    expected[v * stride + i] -= float(weights[i] * (e - std::clamp(e, 0.0, 1.0)) / norm2);
            }
            EXPECT_TRUE(vertices < 37 || (below > 3 && above > 3)) << name;
            for (const EvaluatorPath& path : evaluatorPaths()) {
                std::vector<float> clamped = coefficients;
                path.clamp({weights.data(), stride, float(norm2)}, clamped.data(), vertices);
                EXPECT_LT(largestDifference(clamped, expected), 1e-5) << path.name << " " << name << " " << vertices;
            }
        }
}

// Weights of bytes are rounded to 16 bits: at most half a unit, the largest weight / 32767, times 127 for each
// component, plus what floats round. The cases have an odd count of components, and clusters that end within a tile.
TEST(Evaluator, BytesAreWeighedWithinSixteenBits) {
    const Packed packed =
        pack(tubeModel({.rings = 9, .segments = 7, .clusters = 4, .components = 9}), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t stride = std::size_t(asset.model.stride), size = std::size_t(asset.model.convention.size());
    std::vector<float> weights(stride);
    ambientWeights(asset.model.convention, std::span(weights).first(size));
    for (const EvaluatorPath& path : evaluatorPaths()) {
        evaluator.usePath(path);
        const std::vector<float> coefficients = evaluate(evaluator, 1);
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) {
            const ClusterView& cluster = asset.model.clusters[c];
            const std::span<const float> y = evaluator.scores(c);
            std::vector<float> mean(cluster.mean.count), basis(cluster.basis.count);
            decode(cluster.mean, mean);
            decode(cluster.basis, basis);
            Largest most;
            for (std::size_t k = 0; k < y.size(); ++k) most.add(std::abs(y[k] * cluster.basis.scale[k]));
            const double bound = 0.5 * most / 32767 * 127 * double(y.size()) + 2e-6;
            for (std::size_t v = 0; v < cluster.vertex_count; ++v) {
                std::vector<double> exact(stride);
                double e = 0;
                for (std::size_t i = 0; i < stride; ++i) {
                    exact[i] = mean[v * stride + i];
                    for (std::size_t k = 0; k < y.size(); ++k)
                        exact[i] += double(y[k]) * basis[k * mean.size() + v * stride + i];
                    e += weights[i] * exact[i];
                }
                if (e < 0.001 || e > 0.999) continue;  // clamped
                for (std::size_t i = 0; i < stride; ++i)
                    EXPECT_NEAR(coefficients[(cluster.first_vertex + v) * stride + i], exact[i], bound) << path.name;
            }
        }
    }
}

// Whatever the weights are, sums of 127 times them stay within 32 bits.
TEST(PackWeights, KeepsSumsWithin32Bits) {
    for (std::size_t components : {1u, 2u, 7u, 500u, 5000u}) {
        std::vector<float> weights(components);
        for (std::size_t k = 0; k < components; ++k) weights[k] = k % 3 == 0 ? -2.5f : 2.5f;
        std::vector<std::uint32_t> pairs((components + 1) / 2);
        const float unit = packWeights(weights, pairs);
        double sum = 0;
        for (std::size_t k = 0; k < components; ++k) {
            const auto packed = std::int16_t(k % 2 == 0 ? pairs[k / 2] : pairs[k / 2] >> 16);
            EXPECT_NEAR(packed * double(unit), weights[k], 0.5001 * unit);
            sum += 127.0 * std::abs(packed);
        }
        EXPECT_LT(sum, 2147483648.0) << components;
    }
    std::vector<std::uint32_t> pairs(1, 7);
    EXPECT_EQ(packWeights(std::vector<float>(2), pairs), 0);
    EXPECT_EQ(pairs[0], 0u);
}

TEST(Evaluator, NoSimdInTheEnvironmentLeavesThePortablePath) {
    const NoSimd no_simd;
    EXPECT_EQ(evaluatorPaths().size(), 1u);
    EXPECT_STREQ(evaluatorPaths()[0].name, "portable");
}

TEST(Evaluator, AllocatesNothing) {
    const Packed packed = pack(tubeModel({.clusters = 4}), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount();
    std::vector<float> coefficients(count * std::size_t(asset.model.stride));
    std::vector<Vec3> positions(count), normals(count), tangents(count);
    const std::size_t before = allocationCount();
    evaluator.setPose(asset.animation.bonesOf(0), asset.animation.poseOf(0));
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateCluster(c, coefficients);
    evaluator.skin(0, count, positions, normals, tangents);
    EXPECT_EQ(allocationCount() - before, 0u);
    const std::vector<int> proof(3);
    EXPECT_EQ(allocationCount() - before, 1u) << "the counter does not count";
}

TEST(Evaluator, SameNumbersForAnyThreadCount) {
    const Packed packed = pack(tubeModel({.rings = 40, .segments = 30, .clusters = 16}), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    for (const EvaluatorPath& path : evaluatorPaths()) {
        evaluator.usePath(path);
        const std::vector<float> expected = evaluate(evaluator, 2);
        for (int threads : {2, 8}) {
            std::vector<float> coefficients(expected.size());
            parallelFor(evaluator.clusterCount(), threads,
                        [&](std::size_t c) { evaluator.evaluateCluster(c, coefficients); });
            EXPECT_EQ(largestDifference(coefficients, expected), 0) << path.name;
        }
    }
}

// The evaluator blends in the precision and order of skinVertices(). Measured: 1.2e-7; positions are about 1.
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

// Bones are seen relative to one another, so the scores of a character twice as large are the same.
TEST(Evaluator, TheSizeOfTheWholeCharacterDoesNotMatter) {
    const Packed packed = pack(tubeModel(), AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset), larger(asset);
    std::vector<Affine> bones(asset.animation.bonesOf(1).begin(), asset.animation.bonesOf(1).end());
    evaluator.setPose(bones, {});
    for (Affine& bone : bones)
        for (float& x : bone.m) x *= 2;
    larger.setPose(bones, {});
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c)
        for (std::size_t k = 0; k < evaluator.scores(c).size(); ++k)
            EXPECT_NEAR(larger.scores(c)[k], evaluator.scores(c)[k], 1e-5) << c << " " << k;
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

// A bone scaled to nothing has no inverse. The numbers then mean little, but they are finite.
TEST(Evaluator, SingularBoneGivesFiniteNumbers) {
    Model model = tubeModel();
    for (std::size_t j = 0; j < model.skin.jointCount(); ++j) model.bones[j].m.fill(0);
    const Packed packed = pack(model, AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    for (const EvaluatorPath& path : evaluatorPaths()) {
        evaluator.usePath(path);
        const double largest = largestMagnitude(evaluate(evaluator, 0));
        EXPECT_GT(largest, 0.5) << path.name;
        EXPECT_LT(largest, 10) << path.name;
    }
}

}  // namespace
}  // namespace penumbra::test_evaluator
