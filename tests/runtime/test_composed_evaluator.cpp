// The run time of composed assets: local visibility x far parts + residual.
#include <gtest/gtest.h>

#include "formats/common/parallel_for.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "tests/difference.h"
#include "tests/posed_vertices.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_composed_evaluator {
namespace {

using synthetic::composedTube;

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

// The parts of this one have anchors.
const synthetic::TubeOptions kManyVertices{
    .rings = 120, .segments = 16, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

Packed pack(const Model& model, AssetPrecision precision) {
    return packAsset(model, {}, {}, {.precision = precision}, "{}", 1);
}

std::vector<float> coefficientsOf(Evaluator& evaluator, std::span<const Affine> bones) {
    evaluator.setPose(bones, {});
    return coefficientsOf(evaluator);
}

// Returns what the clusters alone predict. The mean is raised on the way, so that no vertex is clamped.
std::vector<float> clustersAlone(Model model, std::vector<ClusterModel> clusters, std::span<const Affine> bones,
                                 bool raise) {
    model.composition.reset();
    const std::vector<ClusterModel> open = model.clusters;
    if (raise)
        for (std::size_t c = 0; c < clusters.size(); ++c)
            for (std::size_t i = 0; i < clusters[c].mean.size(); ++i) clusters[c].mean[i] += open[c].mean[i];
    model.clusters = clusters;
    const Packed packed = pack(model, AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    std::vector<float> coefficients = coefficientsOf(evaluator, bones), e(evaluator.vertexCount());
    ambient(asset, coefficients, e);
    for (float value : e) EXPECT_TRUE(value > 0.001f && value < 0.999f) << "clamped: " << value;
    if (!raise) return coefficients;
    std::size_t at = 0;
    const std::size_t size = std::size_t(asset.model.convention.size()), stride = std::size_t(asset.model.stride);
    for (const ClusterModel& cluster : open)
        for (std::size_t v = 0; v < cluster.vertices.size(); ++v, at += stride)
            for (std::size_t i = 0; i < size; ++i) coefficients[at + i] -= cluster.mean[v * size + i];
    return coefficients;
}

// The formula, vertex by vertex, with the far parts as evaluateFar() has them.
std::vector<float> expectedNumbers(const Model& model, const AssetView& asset, std::span<const Affine> bones) {
    const Composition& composition = *model.composition;
    std::vector<float> coefficients = clustersAlone(model, model.clusters, bones, false);
    std::vector<float> residual(coefficients.size());
    if (!composition.residual.empty()) residual = clustersAlone(model, composition.residual, bones, true);
    Evaluator evaluator(asset);
    evaluator.setPose(bones, {});
    const std::size_t count = evaluator.vertexCount(), stride = std::size_t(asset.model.stride);
    std::vector<float> far(count * kFarCoefficients), product(std::size_t(model.convention.size()));
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateFar(c, far);
    const int order = model.convention.order;
    const auto size = std::size_t(model.convention.size());
    std::vector<float> weights(size);
    ambientWeights(model.convention, weights);
    float norm2 = 0;
    for (float w : weights) norm2 += w * w;
    for (std::size_t v = 0; v < count; ++v) {
        const std::span<float> row = std::span(coefficients).subspan(v * stride, size);
        multiplyMirrored(order, row, order, std::span(far).subspan(v * kFarCoefficients, kFarCoefficients), kFieldOrder,
                         product);
        for (std::size_t i = 0; i < size; ++i) row[i] = product[i] + residual[v * stride + i];
        clampAmbient(weights, norm2, row);
    }
    return coefficients;
}

// Returns the largest number that the far parts of the asset's frames take away.
double farShare(const AssetView& asset) {
    Evaluator evaluator(asset);
    std::vector<float> far(evaluator.vertexCount() * kFarCoefficients);
    Largest most;
    for (std::size_t f = 0; f < asset.animation.frameCount(); ++f) {
        evaluator.setFrame(f);
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateFar(c, far);
        for (std::size_t v = 0; v < evaluator.vertexCount(); ++v)
            most.add(1 - far[v * kFarCoefficients] / std::sqrt(4 * std::numbers::pi));
    }
    return most;
}

// All vertices of a pose.
struct Skinned {
    std::vector<Vec3> positions, normals, tangents;

    Skinned(const AssetView& asset, std::span<const Affine> bones) {
        Evaluator evaluator(asset);
        evaluator.setPose(bones, {});
        const std::size_t count = evaluator.vertexCount();
        for (std::vector<Vec3>* vectors : {&positions, &normals, &tangents}) vectors->resize(count);
        evaluator.skin(0, count, positions, normals, tangents);
    }
};

// Far visibility of every kStep-th vertex of a pose by farVisibility(). All of them take minutes under sanitizers.
constexpr std::size_t kStep = 5;
std::vector<float> expectedFar(const AssetView& asset, std::span<const Affine> bones) {
    const CompositionView& composition = *asset.model.composition;
    const Skinned skinned(asset, bones);
    const auto& [positions, normals, tangents] = skinned;
    const std::size_t count = positions.size();
    const FarTables tables = makeFarTables(composition, asset.model.convention.order);
    std::vector<PosedPart> posed(tables.partCount());
    poseParts(tables.fields(), bones, posed);
    std::vector<float> far(count * kFarCoefficients);
    for (std::size_t v = 0; v < count; v += kStep) {
        const Receiver receiver{positions[v], normals[v], tangents[v]};
        const std::span<float> out = std::span(far).subspan(v * kFarCoefficients, kFarCoefficients);
        const std::size_t part = composition.part_of_vertex[v], columns = composition.near_count;
        farVisibility(tables.fields(), posed, tables.partsSeenBy(part), receiver, out);
        std::vector<NearPart> nears;
        for (std::size_t n = 0; n < columns; ++n)
            if (const std::uint16_t near_part = composition.near_parts[part * columns + n]; near_part != kNoPart)
                nears.push_back({near_part, float(composition.near_gains[v * columns + n]) / 128});
        multiplyByNear(tables.fields(), posed, nears, receiver, out);
    }
    return far;
}

// Numbers reach 4. Measured: 3e-6.
TEST(ComposedEvaluator, MatchesTheFormulas) {
    Largest off;
    for (const char* convention : {"D5", "D3", "D6", "D8"})
        for (bool residual : {true, false}) {
            synthetic::TubeOptions tube = kTube;
            tube.convention = parseConvention(convention);
            const Model model = composedTube(tube, {.residual = residual});
            const Packed packed = pack(model, AssetPrecision::kF32);
            const AssetView asset = openAsset(packed.bytes);
            EXPECT_GT(farShare(asset), 0.05) << "the far parts block nothing";
            Evaluator evaluator(asset);
            for (std::size_t f = 0; f < asset.animation.frameCount(); ++f) {
                const std::span<const Affine> bones = asset.animation.bonesOf(f);
                const std::vector<float> expected = expectedNumbers(model, asset, bones);
                for (const EvaluatorPath& path : evaluatorPaths()) {
                    evaluator.usePath(path);
                    off.add(largestDifference(coefficientsOf(evaluator, bones), expected));
                }
            }
        }
    EXPECT_LT(off, 1e-5);
}

// The far factor of every kStep-th vertex against the plain form, over all frames, and whether near parts take part.
struct NearOff {
    Largest off, by_near_parts;
};
NearOff nearOff(const synthetic::TubeOptions& tube, std::size_t columns) {
    Model model = composedTube(tube, {.local_steps = 2});
    synthetic::addNearParts(model, columns);
    const Packed packed = pack(model, AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    std::vector<float> far(evaluator.vertexCount() * kFarCoefficients), without(far.size());
    NearOff result;
    for (std::size_t f = 0; f < asset.animation.frameCount(); ++f) {
        const std::vector<float> expected = expectedFar(asset, asset.animation.bonesOf(f));
        for (const EvaluatorPath& path : evaluatorPaths()) {
            evaluator.usePath(path);
            evaluator.setFrame(f);
            for (const NearFactors factors : {NearFactors::kWithout, NearFactors::kWith}) {
                evaluator.setNearFactors(factors);
                for (std::size_t c = 0; c < evaluator.clusterCount(); ++c)
                    evaluator.evaluateFar(c, factors == NearFactors::kWith ? far : without);
            }
            for (std::size_t v = 0; v < evaluator.vertexCount(); v += kStep)
                for (std::size_t i = v * kFarCoefficients; i < (v + 1) * kFarCoefficients; ++i) {
                    result.off.add(std::abs(far[i] - expected[i]));
                    result.by_near_parts.add(std::abs(far[i] - without[i]));
                }
        }
    }
    return result;
}

// Few vertices have no anchors, and the plain form cuts off what the directions keep. Numbers reach 3.5.
TEST(ComposedEvaluator, NearPartsAreThoseOfThePlainForm) {
    for (const std::size_t columns : {1, 4}) {
        const NearOff error = nearOff(kTube, columns);
        EXPECT_LT(error.off, 0.05) << columns;
        EXPECT_GT(error.by_near_parts, 0.3) << columns;
    }
}

// A ball as a vertex sees it.
struct SeenBall {
    Vec3 way;  // from the vertex to the centre
    float distance2, radius2;
};

std::vector<SeenBall> ballsSeenFrom(const FarTables& tables, std::uint16_t part, std::span<const Affine> bones,
                                    Vec3 position) {
    std::vector<SeenBall> balls;
    for (const std::uint16_t p : tables.partsSeenBy(part)) {
        const FieldTable& ball = tables.fields().tables[p];
        const Vec3 way = bones[tables.fields().joints[p]].point(ball.center) - position;
        balls.push_back({way, dot(way, way), ball.radius * ball.radius});
    }
    return balls;
}

bool blocks(const SeenBall& ball, Vec3 direction) {
    const float along = dot(ball.way, direction);
    return along > 0 && ball.distance2 - along * along <= ball.radius2;
}

// What the far balls leave visible at all vertices of a pose, counted over directions above each horizon.
std::vector<float> countedFar(const AssetView& asset, std::span<const Affine> bones) {
    const CompositionView& composition = *asset.model.composition;
    const Skinned skinned(asset, bones);
    const auto& [positions, normals, tangents] = skinned;
    const std::size_t count = positions.size();
    const FarTables tables = makeFarTables(composition, asset.model.convention.order);
    const std::vector<WeightedDirection> directions = gaussHemisphere(24, 96);
    const std::vector<int> even = evenIndices(kFieldOrder);
    std::vector<float> far(count * kFarCoefficients);
    std::vector<double> y(kFieldCoefficients);
    std::vector<std::array<float, kFarCoefficients>> rows;  // what an open direction adds
    for (const WeightedDirection& d : directions) {
        evalBasis(kFieldOrder, d.direction, y);
        std::array<float, kFarCoefficients>& row = rows.emplace_back();
        for (std::size_t e = 0; e < kFarCoefficients; ++e) row[e] = float(2 * d.weight * y[std::size_t(even[e])]);
    }
    for (std::size_t v = 0; v < count; v += kStep) {
        const std::vector<SeenBall> balls = ballsSeenFrom(tables, composition.part_of_vertex[v], bones, positions[v]);
        const Vec3d side = toDouble(cross(normals[v], tangents[v]));
        for (std::size_t i = 0; i < directions.size(); ++i) {
            const Vec3d local = directions[i].direction;
            const Vec3 s = toFloat(toDouble(tangents[v]) * local.x + side * local.y + toDouble(normals[v]) * local.z);
            if (std::ranges::any_of(balls, [s](const SeenBall& ball) { return blocks(ball, s); })) continue;
            for (std::size_t e = 0; e < kFarCoefficients; ++e) far[v * kFarCoefficients + e] += rows[i][e];
        }
    }
    return far;
}

// How far evaluateFar() and farVisibility() are from what is counted, in all frames, relative to what the far parts
// take away.
struct FarError {
    double evaluated = 0, reference = 0;
};
FarError farError(const synthetic::TubeOptions& tube, float radius, FarQuality quality = FarQuality::kFull) {
    const Packed packed = pack(composedTube(tube, {.radius = radius}), AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    evaluator.setQuality(quality);
    double evaluated = 0, reference = 0, signal = 0;
    for (std::size_t f = 0; f < asset.animation.frameCount(); ++f) {
        evaluator.setFrame(f);
        std::vector<float> far(evaluator.vertexCount() * kFarCoefficients);
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateFar(c, far);
        const std::vector<float> expected = expectedFar(asset, asset.animation.bonesOf(f)),
                                 counted = countedFar(asset, asset.animation.bonesOf(f));
        for (std::size_t i = 0; i < far.size(); ++i) {
            if (i / kFarCoefficients % kStep != 0) continue;
            const double open = i % kFarCoefficients == 0 ? std::sqrt(4 * std::numbers::pi) : 0;
            evaluated += std::pow(far[i] - counted[i], 2);
            reference += std::pow(expected[i] - counted[i], 2);
            signal += std::pow(counted[i] - open, 2);
        }
    }
    EXPECT_GT(signal, 1);
    return {std::sqrt(evaluated / signal), std::sqrt(reference / signal)};
}

// Six bands cut small balls off, so that farVisibility() itself is off by .64, .27 and .42. Small parts multiply all
// others in. Large ones sum at anchors what blocks little, which costs most where nothing else blocks. Measured: .646,
// .479 and .476.
TEST(ComposedEvaluator, IsAsCloseToRaysAsTheReferenceAndSumsAreNear) {
    synthetic::TubeOptions few = kTube, many = kManyVertices;
    few.joints = many.joints = 12;
    for (const auto& [radius, most] : {std::pair{0.05f, 0.66}, {0.08f, 0.5}, {0.2f, 0.5}}) {
        const FarError multiplied = farError(few, radius), summed = farError(many, radius);
        EXPECT_LT(multiplied.evaluated, 1.02 * multiplied.reference) << radius;
        EXPECT_LT(summed.evaluated, most) << radius;
        EXPECT_LT(summed.reference, 0.65) << radius;
    }
}

TEST(ComposedEvaluator, FastQualityHasMoreErrorAndFewerAnchors) {
    synthetic::TubeOptions many = kManyVertices;
    many.joints = 12;
    const double full = farError(many, 0.08f).evaluated, fast = farError(many, 0.08f, FarQuality::kFast).evaluated;
    EXPECT_GT(fast, full);
    EXPECT_LT(fast, 1.5 * full);
    const Packed packed = pack(composedTube(many), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t anchors = evaluator.farLayout().anchors.size();
    evaluator.setQuality(FarQuality::kFast);
    EXPECT_LT(evaluator.farLayout().anchors.size(), anchors);
}

TEST(ComposedEvaluator, ARigOfOnePartHasNoFarPart) {
    synthetic::TubeOptions tube = kTube;
    tube.joints = 1;
    tube.inputs = 3;
    tube.features = FeatureKind::kJointAngles;
    const Model model = composedTube(tube, {.residual = false});
    Model additive = model;
    additive.composition.reset();
    const Packed a = pack(model, AssetPrecision::kF32), b = pack(additive, AssetPrecision::kF32);
    const AssetView composed = openAsset(a.bytes), plain = openAsset(b.bytes);
    Evaluator first(composed), second(plain);
    const auto coefficients = [](Evaluator& evaluator) {
        evaluator.setFrame(1);
        return coefficientsOf(evaluator);
    };
    for (const EvaluatorPath& path : evaluatorPaths()) {
        first.usePath(path);
        second.usePath(path);
        EXPECT_LT(largestDifference(coefficients(first), coefficients(second)), 2e-6) << path.name;
    }
}

TEST(ComposedEvaluator, EveryPathAgreesWithThePortableOne) {
    for (AssetPrecision precision : {AssetPrecision::kF32, AssetPrecision::kF16, AssetPrecision::kI8}) {
        const Packed packed = pack(composedTube(kManyVertices), precision);
        const AssetView asset = openAsset(packed.bytes);
        Evaluator evaluator(asset);
        const std::vector<EvaluatorPath> paths = evaluatorPaths();
        evaluator.usePath(paths.front());
        const std::vector<float> expected = coefficientsOf(evaluator, asset.animation.bonesOf(1));
        for (const EvaluatorPath& path : paths) {
            evaluator.usePath(path);
            EXPECT_LT(largestDifference(coefficientsOf(evaluator, asset.animation.bonesOf(1)), expected), 5e-6)
                << path.name << " " << nameOf(precision);
        }
    }
}

TEST(ComposedEvaluator, AllocatesNothing) {
    const Packed packed = pack(composedTube(kManyVertices), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    std::vector<float> coefficients(evaluator.vertexCount() * std::size_t(asset.model.stride));
    const std::size_t before = allocationCount();
    evaluator.setPose(asset.animation.bonesOf(0), {});
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateCluster(c, coefficients);
    EXPECT_EQ(allocationCount() - before, 0u);
}

TEST(ComposedEvaluator, SameNumbersForAnyThreadCountAndForCopies) {
    const Packed packed = pack(composedTube(kManyVertices), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    for (const EvaluatorPath& path : evaluatorPaths()) {
        evaluator.usePath(path);
        const std::vector<float> expected = coefficientsOf(evaluator, asset.animation.bonesOf(2));
        for (int threads : {2, 8}) {
            Evaluator copy(evaluator);
            std::vector<float> coefficients(expected.size());
            copy.setPose(asset.animation.bonesOf(2), {});
            parallelFor(copy.clusterCount(), threads, [&](std::size_t c) { copy.evaluateCluster(c, coefficients); });
            EXPECT_EQ(largestDifference(coefficients, expected), 0) << path.name;
        }
    }
}

// A pose of huge or singular bones means little, but its numbers are finite and E stays in [0, 1].
TEST(ComposedEvaluator, NoPoseMakesItExplode) {
    const Packed packed = pack(composedTube(kManyVertices), AssetPrecision::kI8);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    std::vector<float> e(evaluator.vertexCount());
    for (float size : {0.0f, 1.0f, 1e3f, 1e6f}) {
        std::vector<Affine> bones(std::size_t(kManyVertices.joints));
        for (std::size_t j = 0; j < bones.size(); ++j)
            for (std::size_t i = 0; i < 12; ++i) bones[j].m[i] = size * std::sin(float(7 * j + 3 * i) + size);
        for (const EvaluatorPath& path : evaluatorPaths()) {
            evaluator.usePath(path);
            const std::vector<float> coefficients = coefficientsOf(evaluator, bones);
            EXPECT_GT(largestMagnitude(coefficients), 0.3) << size;
            ambient(asset, coefficients, e);
            for (float value : e) EXPECT_TRUE(value >= -1e-5f && value <= 1 + 1e-5f) << size << " " << value;
        }
    }
}

// Turns every joint of the tube about x by `angle` more than its parent, as a curl.
std::vector<Affine> curl(const Model& model, double angle) {
    std::vector<Affine> bones;
    const double c = std::cos(angle), s = std::sin(angle);
    const Mat3d turn{{1, 0, 0, 0, c, -s, 0, s, c}};
    Mat3d rotation;
    Vec3d translation;
    for (Vec3 center : model.joint_centers) {
        const Vec3d at = toDouble(center);
        translation += rotation * (at - turn * at);
        rotation = rotation * turn;
        const auto& m = rotation.m;
        const Vec3d& t = translation;
        bones.push_back({{float(m[0]), float(m[1]), float(m[2]), float(t.x), float(m[3]), float(m[4]), float(m[5]),
                          float(t.y), float(m[6]), float(m[7]), float(m[8]), float(t.z)}});
    }
    return bones;
}

// The tube curls up until its ends go through one another. Parts come above the horizon, into reach and into each other
// on the way. E of the far parts alone changes by .88. Measured: no step is above .0124, and none exceeds the larger of
// those next to it by more than .0052: that is where a vertex begins to go dark inside a part, over a depth of 0.2.
// Before that it is .0007.
TEST(ComposedEvaluator, NothingPopsOverAThousandFrames) {
    const Model model = composedTube(kManyVertices, {.fade = 0.2f, .residual = false});
    const Packed packed = pack(model, AssetPrecision::kF32);
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount();
    std::vector<float> far(count * kFarCoefficients);
    std::vector<std::vector<float>> e;
    for (int frame = 0; frame < 1000; ++frame) {
        evaluator.setPose(curl(model, 1.25 * frame / 1000), {});
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateFar(c, far);
        ambient(parseConvention("D6"), int(kFarCoefficients), far, e.emplace_back(count));
    }
    Largest largest, jump, range;
    for (std::size_t v = 0; v < count; ++v)
        for (std::size_t f = 1; f + 2 < e.size(); ++f) {
            const float before = std::abs(e[f][v] - e[f - 1][v]), step = std::abs(e[f + 1][v] - e[f][v]),
                        after = std::abs(e[f + 2][v] - e[f + 1][v]);
            largest.add(step);
            jump.add(step - std::max(before, after));
            range.add(std::abs(e[f][v] - e[0][v]));
        }
    EXPECT_GT(range, 0.1f) << "nothing happens";
    EXPECT_LT(largest, 0.02f);
    EXPECT_LT(jump, 0.008f);
}

}  // namespace
}  // namespace penumbra::test_composed_evaluator
