#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "formats/asset/mapped_file.h"
#include "formats/common/errors.h"
#include "pack/check/check_asset.h"
#include "pack/check/check_sums.h"
#include "pack/check/error_budget.h"
#include "pack/check/rank_correlation.h"
#include "pack/compress/packing_error.h"
#include "pack/compress/span_projector.h"
#include "pack/pack_asset.h"
#include "pack/pack_truth.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"
#include "tests/difference.h"
#include "tests/posed_vertices.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_check_asset {
namespace {

namespace fs = std::filesystem;

Model livelyTube() {
    Model model = synthetic::tubeModel({.frames = 6, .convention = parseConvention("B4")});
    synthetic::turnJointsApart(model);
    return model;
}

// A bake whose visibility is what the model says, plus noise. Convention B's numbers are the moments themselves.
struct SyntheticBake {
    Model model;
    Packed packed;
    AssetView asset;
    fs::path path;
    std::vector<float> noise;  // [F, V, 16], local frame, asset order
    std::uint32_t seed;

    explicit SyntheticBake(float amount, std::uint32_t noise_seed = 9)
        : model(livelyTube()),
          packed(packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1)),
          asset(openAsset(packed.bytes)),
          path(fs::temp_directory_path() /
               ("check" + std::to_string(::getpid()) + "_" + std::to_string(noise_seed) + ".vis.h5")),
          seed(noise_seed) {
        synthetic::Noise source(seed);
        synthetic::fillNoise(noise, asset.animation.frameCount() * model.mesh.vertexCount() * 16, amount, source);
        write();
    }
    ~SyntheticBake() { fs::remove(path); }

    void write() const {
        VisibilityHeader header;
        header.order = 4;
        header.rays = 16;
        header.seed = seed;
        header.mesh = model.mesh;
        header.skin = model.skin;
        header.rest_normals = model.rest_normals;
        header.frames = model.frames;
        header.pose_size = model.pose_size;
        header.provenance = model.provenance;
        VisibilityWriter writer(path, header, Precision::kFloat32);
        for (std::size_t f = 0; f < model.frames.frameCount(); ++f) writer.writeFrame(frame(f));
        writer.finish();
    }

    VisibilityFrame frame(std::size_t f) const {
        Evaluator evaluator(asset);
        const std::size_t count = evaluator.vertexCount(), joints = model.skin.jointCount();
        evaluator.setPose(asset.animation.bonesOf(f), {});
        const auto [positions, normals, tangents, coefficients, indirect] = PosedArrays(evaluator);
        VisibilityFrame out;
        out.positions.resize(count);
        out.normals.resize(count);
        out.bones.assign(model.bones.begin() + long(f * joints), model.bones.begin() + long((f + 1) * joints));
        out.pose.assign(model.pose.begin() + long(f) * model.pose_size,
                        model.pose.begin() + long(f + 1) * model.pose_size);
        out.coefficients.resize(count * 16);
        for (std::size_t v = 0; v < count; ++v) {
            const std::size_t point = asset.mesh.shading_point[v];
            out.positions[point] = positions[v];
            out.normals[point] = normals[v];
            std::vector<float> local(16);
            for (std::size_t i = 0; i < 16; ++i) local[i] = coefficients[v * 16 + i] + noise[(f * count + v) * 16 + i];
            applyTransposed(makeShRotation(4, toLocalFrame(normals[v], tangents[v])), local,
                            std::span(out.coefficients).subspan(point * 16, 16));
        }
        return out;
    }
};

const auto kNoProgress = [](std::size_t) {};

// Measured: 2e-6, from single-precision rotations there and back.
TEST(CheckAsset, AModelThatMadeTheTruthHasNoError) {
    const SyntheticBake bake(0);
    const VisibilityReader truth(bake.path);
    const CheckResult result = checkAsset(bake.asset, truth, {.predictions = &truth}, 2, kNoProgress);
    ASSERT_EQ(result.clips.size(), 2u);
    EXPECT_FALSE(result.clips[0].held_out);
    EXPECT_TRUE(result.clips[1].held_out);
    EXPECT_TRUE(result.mean_from_truth);
    for (const ErrorFigures& f : {result.clips[0], result.clips[1], result.training, result.held_out}) {
        EXPECT_EQ(f.frames, 3u);
        EXPECT_LT(f.relative_error, 2e-5);
        EXPECT_LT(f.truncation, 2e-5);
        EXPECT_LT(f.prediction_difference, 2e-5);
        EXPECT_LT(f.ambient_error, 1e-6);
    }
}

// Returns the sum over a clip's frames of (y - mean)^2, with the mean over the first (the training) clip's frames; y
// = model + noise.
double variationOf(const SyntheticBake& bake, std::size_t clip) {
    Evaluator evaluator(bake.asset);
    const std::size_t count = evaluator.vertexCount() * 16;
    std::vector<double> y, mean(count);
    for (std::size_t f = 0; f < 6; ++f) {
        evaluator.setPose(bake.asset.animation.bonesOf(f), {});
        const std::vector<float> coefficients = coefficientsOf(evaluator);
        for (std::size_t i = 0; i < count; ++i) {
            y.push_back(double(coefficients[i]) + bake.noise[f * count + i]);
            if (f < 3) mean[i] += y.back() / 3;
        }
    }
    double sum = 0;
    for (std::size_t i = 3 * clip * count; i < 3 * (clip + 1) * count; ++i) sum += std::pow(y[i] - mean[i % count], 2);
    return sum;
}

// The noise is all of the error, so rms V is its root mean square, and relative^2 = truncation^2 + regression^2.
TEST(CheckAsset, FiguresAreThoseOfTheNoise) {
    const SyntheticBake bake(0.1f);
    const VisibilityReader truth(bake.path);
    const CheckResult result = checkAsset(bake.asset, truth, {}, 1, kNoProgress);
    const std::size_t half = bake.noise.size() / 2, vertices = bake.model.mesh.vertexCount();
    for (int clip : {0, 1}) {
        double squares = 0, ambient_error = 0;
        Largest largest_error;
        std::vector<float> weights(16);
        ambientWeights(bake.model.convention, weights);
        for (std::size_t i = 0; i < half; i += 16) {
            double e = 0;
            for (std::size_t j = 0; j < 16; ++j) {
                const double noise = bake.noise[std::size_t(clip) * half + i + j];
                squares += noise * noise;
                e += weights[j] * noise;
            }
            ambient_error += std::abs(e);
            largest_error.add(std::abs(e));
        }
        const ErrorFigures& f = result.clips[std::size_t(clip)];
        EXPECT_NEAR(f.rms_v, std::sqrt(squares / double(3 * vertices) / (4 * std::numbers::pi)), 1e-6);
        EXPECT_NEAR(f.relative_error, std::sqrt(squares / variationOf(bake, std::size_t(clip))), 1e-5);
        EXPECT_NEAR(f.ambient_error, ambient_error / double(3 * vertices), 1e-6);
        const double largest = largest_error.value();
        EXPECT_NEAR(f.ambient_max, largest, 1e-6);
        EXPECT_GT(f.ambient_p999, 0.9 * largest) << "of some 300 pairs that is the largest but for the bin";
        EXPECT_NEAR(std::hypot(f.truncation, f.regression), f.relative_error, 1e-9);
        EXPECT_EQ(f.relative_error, (clip ? result.held_out : result.training).relative_error);
        EXPECT_GT(f.regression, 0);
        EXPECT_GT(f.truncation, f.regression) << "noise lies mostly outside a span of 3";
    }
}

// The difference of two bakes of one truth, / sqrt 2, is the root mean square of the noise of both.
TEST(CheckAsset, BakeNoiseIsTheDifferenceOfTwoBakes) {
    const SyntheticBake bake(0.1f), other(0.1f, 10);
    const VisibilityReader truth(bake.path), second(other.path);
    const CheckResult result = checkAsset(bake.asset, truth, {.second_bake = &second}, 2, kNoProgress);
    const std::size_t half = bake.noise.size() / 2;
    for (std::size_t clip : {0, 1}) {
        double squares = 0;
        for (std::size_t i = clip * half; i < (clip + 1) * half; ++i)
            squares += std::pow(double(bake.noise[i]) - other.noise[i], 2) / 2;
        EXPECT_NEAR(result.clips[clip].bake_noise, std::sqrt(squares / variationOf(bake, clip)), 1e-5);
    }
    EXPECT_TRUE(std::isnan(result.held_out.packing)) << "not measured";
    EXPECT_THROW(checkAsset(bake.asset, truth, {.second_bake = &truth}, 1, kNoProgress), InvalidInput);
    SyntheticBake moved(0.1f, 11);
    moved.model.bones[4].m[3] += 0.01f;
    moved.write();
    const VisibilityReader other_pose(moved.path);
    EXPECT_THROW(checkAsset(bake.asset, truth, {.second_bake = &other_pose}, 1, kNoProgress), InvalidInput);
}

// Noise that grows with the distance gives both the same order. A frame that is nearer than it is bad turns the order
// around.
TEST(CheckAsset, ErrorThatGrowsWithTheDistanceHasRankCorrelationOne) {
    SyntheticBake bake(0.1f);
    for (ClusterModel& cluster : bake.model.clusters)  // what the frames of "twist" reach beyond
        for (std::size_t i = 0; i < cluster.group_min.size(); ++i) {
            const float middle = (cluster.group_min[i] + cluster.group_max[i]) / 2;
            cluster.group_min[i] = cluster.group_max[i] = middle;
        }
    bake.packed = packAsset(bake.model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    bake.asset = openAsset(bake.packed.bytes);
    std::vector<double> distance;
    Evaluator evaluator(bake.asset);
    for (std::size_t f = 0; f < 6; ++f) {
        evaluator.setPose(bake.asset.animation.bonesOf(f), {});
        distance.push_back(evaluator.outOfRange());
    }
    const std::size_t count = bake.noise.size() / 6;
    for (double sign : {1.0, -1.0}) {
        const std::vector<float> noise = bake.noise;
        for (std::size_t i = 0; i < noise.size(); ++i)
            bake.noise[i] *= float(std::pow(distance[i / count] / distance[3], 2 * sign));
        bake.write();
        bake.noise = noise;
        const CheckResult result = checkAsset(bake.asset, VisibilityReader(bake.path), {}, 2, kNoProgress);
        ASSERT_EQ(result.frames.size(), 6u);
        double squares = 0;
        for (std::size_t f = 3; f < 6; ++f) {
            EXPECT_EQ(result.frames[f].clip, "twist");
            EXPECT_TRUE(result.frames[f].held_out);
            EXPECT_EQ(result.frames[f].out_of_range, distance[f]);
            squares += result.frames[f].rms_v * result.frames[f].rms_v / 3;
        }
        EXPECT_NEAR(std::sqrt(squares), result.held_out.rms_v, 1e-12);
        EXPECT_NEAR(rangeCorrelation(result), sign, 1e-12);
    }
}

TEST(RankCorrelation, KnownOrders) {
    const std::vector<double> a = {3, 1, 4, 1.5, 9}, b = {30, 1, 31, 2, 1e6}, reversed = {-3, -1, -4, -1.5, -9};
    EXPECT_NEAR(rankCorrelation(a, b), 1, 1e-12);
    EXPECT_NEAR(rankCorrelation(a, reversed), -1, 1e-12);
    // Ranks are 1 2.5 2.5 4 and 1 2 3 4, less 2.5: (2.25 + 0 + 0 + 2.25) / sqrt(4.5 * 5).
    EXPECT_NEAR(rankCorrelation(std::vector<double>{1, 2, 2, 3}, std::vector<double>{1, 2, 3, 4}),
                4.5 / std::sqrt(22.5), 1e-12);
    EXPECT_TRUE(std::isnan(rankCorrelation(std::vector<double>{1, 1, 1}, std::vector<double>{1, 2, 3})));
    EXPECT_TRUE(std::isnan(rankCorrelation({}, {})));
}

TEST(CheckAsset, NaNShowsInWhateverItReaches) {
    ClipSums clip{"walk", false, 1, 0, std::vector<CheckSums>(1), {0}};
    CheckSums& sums = clip.of_cluster[0];
    sums.truth_squares = 1;
    sums.error = sums.outside = sums.sh_outside = sums.packing = std::nan("");
    const ErrorFigures figures =
        figuresOf({&clip, 1}, {}, {.composed = false, .true_local = false, .unpacked = true, .vertices = 1}).training;
    for (const double figure :
         {figures.relative_error, figures.truncation, figures.regression, figures.sh_truncation, figures.packing})
        EXPECT_TRUE(std::isnan(figure));
    EXPECT_EQ(figures.unpacked_error, 0);
}

// With fewer, rounded components, the span and the error of the model stay those of the model, whatever is packed.
// All parts make the total up to the correlation of the last two.
TEST(CheckAsset, BudgetSplitsTheErrorOfAPackedModel) {
    const SyntheticBake bake(0.1f);
    const VisibilityReader truth(bake.path);
    const Packed small = packAsset(bake.model, {}, {}, {.max_error = 0.3}, "{}", 1);
    ASSERT_LT(small.components, small.all_components);
    const AssetView asset = openAsset(small.bytes);
    const ErrorFigures exact = checkAsset(bake.asset, truth, {}, 1, kNoProgress).training;
    const CheckReferences references{.unpacked = &bake.asset};
    const ErrorFigures packed = checkAsset(asset, truth, references, 1, kNoProgress).training;
    EXPECT_NEAR(packed.unpacked_error, exact.relative_error, 1e-9);
    EXPECT_NEAR(packed.unpacked_truncation, exact.truncation, 1e-9);
    EXPECT_GT(packed.truncation, exact.truncation);
    // The packer's own measure over these frames must agree; measured: 1e-9.
    const double difference = comparePacked(asset, bake.asset, 1).difference;
    EXPECT_NEAR(packed.packing, std::sqrt(difference / variationOf(bake, 0)), 1e-6);
    EXPECT_GT(packed.packing, 0.005);
    EXPECT_EQ(checkAsset(bake.asset, truth, references, 1, kNoProgress).training.packing, 0);
    EXPECT_NEAR(std::hypot(packed.unpacked_error, packed.packing), packed.relative_error, 0.1 * packed.relative_error);
    const std::vector<BudgetRow> rows = errorBudget(packed);
    const auto row = [&](const std::string& name) {
        for (const BudgetRow& r : rows)
            if (r.name == name) return r;
        return BudgetRow{};
    };
    EXPECT_NEAR(std::hypot(row("output PCA").relative, row("regression").relative), row("unpacked model").relative,
                1e-12);
    EXPECT_NEAR(row("total").rms_v, packed.rms_v, 1e-12);
    EXPECT_TRUE(std::isnan(row("bake noise").relative));
    EXPECT_EQ(row("bake noise").option, "a second bake");
    EXPECT_NEAR(std::hypot(row("total").relative, row("SH truncation").relative), row("against all bands").relative,
                1e-12);
}

TEST(CheckAsset, RefusesTheModelOfAnotherAsset) {
    const SyntheticBake bake(0);
    const VisibilityReader truth(bake.path);
    const Model other = synthetic::tubeModel({.clusters = 3, .frames = 6, .convention = parseConvention("B4")});
    const Packed packed = packAsset(other, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    const AssetView unpacked = openAsset(packed.bytes);
    EXPECT_THROW(checkAsset(bake.asset, truth, {.unpacked = &unpacked}, 1, kNoProgress), InvalidInput);
}

TEST(CheckAsset, SameFiguresForAnyThreadCount) {
    const SyntheticBake bake(0.1f);
    const VisibilityReader truth(bake.path);
    const double expected = checkAsset(bake.asset, truth, {}, 1, kNoProgress).held_out.relative_error;
    EXPECT_EQ(checkAsset(bake.asset, truth, {}, 8, kNoProgress).held_out.relative_error, expected);
}

TEST(CheckAsset, RefusesAnotherMesh) {
    SyntheticBake bake(0);
    bake.model.mesh.rest_positions[3].x += 0.01f;
    bake.write();
    const VisibilityReader moved(bake.path);
    EXPECT_THROW(checkAsset(bake.asset, moved, {}, 1, kNoProgress), InvalidInput);
}

TEST(PackTruth, HoldsTheMomentsOfTheChosenClips) {
    const SyntheticBake bake(0.1f);
    const VisibilityReader reader(bake.path);
    const fs::path out = bake.path.string() + ".truth.pnb";
    for (AssetPrecision precision : {AssetPrecision::kF32, AssetPrecision::kF16}) {
        const TruthOptions options{precision, {"twist"}};
        const TruthPlan plan = planTruth(reader, options);
        packTruth(reader, plan, options, "{}", out, kNoProgress);
        const MappedFile file(out);
        const AssetView truth = openAsset(file.bytes(), out.string());
        ASSERT_TRUE(truth.has_truth && !truth.has_model);
        ASSERT_EQ(truth.animation.clips.size(), 1u);
        EXPECT_EQ(truth.animation.clips[0].name, "twist");
        EXPECT_EQ(truth.animation.frameCount(), 3u);
        EXPECT_EQ(truth.animation.bonesOf(1)[2], bake.asset.animation.bonesOf(4)[2]);
        std::vector<float> moments(16);
        const VisibilityFrame frame = reader.readFrame(4);
        for (std::size_t v = 0; v < truth.mesh.positions.size(); ++v) {
            readTruth(truth, 1, v, moments);
            for (std::size_t i = 0; i < 16; ++i)
                EXPECT_NEAR(moments[i], frame.coefficients[v * 16 + i], precision == AssetPrecision::kF32 ? 0 : 2e-3);
        }
    }
    fs::remove(out);
    EXPECT_THROW(planTruth(reader, {AssetPrecision::kF16, {"walk"}}), UsageError);
}

// Truth as numbers is the model's numbers again. Measured: 1e-6.
TEST(PackTruth, AsNumbersIsWhatTheModelSaid) {
    const SyntheticBake bake(0);
    const VisibilityReader reader(bake.path);
    const fs::path out = bake.path.string() + ".truth.pnb";
    const TruthOptions options{AssetPrecision::kF32, {}};
    packTruth(reader, planTruth(reader, options), options, "{}", out, kNoProgress);
    const MappedFile file(out);
    const AssetView truth = openAsset(file.bytes());
    Evaluator evaluator(bake.asset);
    evaluator.setPose(bake.asset.animation.bonesOf(2), {});
    const PosedArrays expected(evaluator);
    std::vector<float> coefficients(expected.coefficients.size());
    coefficientsFromTruth(truth, 2, bake.asset, expected.all(), coefficients);
    for (std::size_t i = 0; i < coefficients.size(); ++i) ASSERT_NEAR(coefficients[i], expected.coefficients[i], 1e-5);
    fs::remove(out);
}

TEST(SpanProjector, DistanceFromAPlaneInSpace) {
    const SpanProjector plane({1, 1, 0, 0, 2, 0, 3, 5, 0}, 3);  // the xy plane, one direction too many
    const std::vector<float> point = {3, -2, 7}, origin = {1, 1, 4};
    EXPECT_NEAR(plane.squaredDistance(point, origin), 9, 1e-12);
    EXPECT_NEAR(SpanProjector({}, 3).squaredDistance(point, origin), 4 + 9 + 9, 1e-12);
}

TEST(SpanProjector, ProjectsOntoAPlaneInSpace) {
    const SpanProjector plane({1, 1, 0, 0, 2, 0, 3, 5, 0}, 3);
    const std::vector<float> origin{1, 2, 3}, point{3, -1, 7};
    std::vector<float> nearest(3);
    plane.project(point, origin, nearest);
    EXPECT_NEAR(nearest[0], 3, 1e-6);
    EXPECT_NEAR(nearest[1], -1, 1e-6);
    EXPECT_NEAR(nearest[2], 3, 1e-6);
    SpanProjector({}, 3).project(point, origin, nearest);
    EXPECT_EQ(nearest, origin);
}

}  // namespace
}  // namespace penumbra::test_check_asset
