#include <gtest/gtest.h>

#include <cmath>

#include "formats/common/errors.h"
#include "pack/compress/compress_model.h"
#include "pack/compress/dense_solvers.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "tests/refusal.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_compress_model {
namespace {

// Products are lazy, as tests/CMakeLists.txt says.
TEST(SymmetricAxes, RebuildTheMatrixFromOrthonormalVectors) {
    synthetic::Noise noise(4);
    for (Eigen::Index n : {1, 2, 7, 30, 130}) {
        Eigen::MatrixXd a(n, n);
        for (Eigen::Index i = 0; i < n; ++i)
            for (Eigen::Index j = 0; j <= i; ++j) a(i, j) = a(j, i) = noise();
        const SymmetricAxes of = symmetricAxes(a);
        for (Eigen::Index k = 1; k < n; ++k) EXPECT_GE(of.values[k - 1], of.values[k]);
        const Eigen::MatrixXd scaled = of.axes * of.values.asDiagonal();
        EXPECT_LT((scaled.lazyProduct(of.axes.transpose()) - a).norm(), 1e-12);
        EXPECT_LT((of.axes.transpose().lazyProduct(of.axes) - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-12);
    }
}

constexpr std::size_t kFrames = 40, kUnits = 9, kCoefficients = 60;

// A cluster of `components`, and its units' values h [F, H] over some frames, from which everything follows.
struct Example {
    ClusterModel cluster;
    std::vector<float> units;

    explicit Example(std::size_t components) {
        synthetic::Noise noise(3);
        synthetic::fillNoise(units, kFrames * kUnits, 1, noise);
        synthetic::fillNoise(cluster.weights, components * kUnits, 1, noise);
        synthetic::fillNoise(cluster.bias, components, 2, noise);
        synthetic::fillNoise(cluster.mean, kCoefficients, 1, noise);
        synthetic::fillNoise(cluster.basis, components * kCoefficients, 0.2f, noise);
        for (std::size_t i = 0; i < cluster.weights.size(); ++i)  // components of unequal weight
            cluster.weights[i] /= float(1 + i / kUnits);
    }

    std::vector<float> scores(const ClusterModel& of) const {  // [F, K]
        std::vector<float> y;
        for (std::size_t f = 0; f < kFrames; ++f)
            for (std::size_t k = 0; k < of.components(); ++k) {
                double sum = of.bias[k];
                for (std::size_t h = 0; h < kUnits; ++h) sum += of.weights[k * kUnits + h] * units[f * kUnits + h];
                y.push_back(float(sum));
            }
        return y;
    }
    std::vector<double> coefficients(const ClusterModel& of) const {  // [F, numbers]
        const std::vector<float> y = scores(of);
        std::vector<double> out;
        for (std::size_t f = 0; f < kFrames; ++f)
            for (std::size_t n = 0; n < kCoefficients; ++n) {
                double sum = of.mean[n];
                for (std::size_t k = 0; k < of.components(); ++k)
                    sum += double(y[f * of.components() + k]) * of.basis[k * kCoefficients + n];
                out.push_back(sum);
            }
        return out;
    }
    std::vector<double> turn() {
        const std::vector<float> y = scores(cluster);
        return turnToPrincipalAxes(cluster, y);
    }
};

// Measured: 1.5e-6 of numbers up to 6.
TEST(CompressModel, TurningChangesNoNumber) {
    Example example(6);
    const std::vector<double> before = example.coefficients(example.cluster);
    const std::vector<double> energies = example.turn();
    const std::vector<double> after = example.coefficients(example.cluster);
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-5);
    const std::vector<float> y = example.scores(example.cluster);
    ASSERT_EQ(energies.size(), 6u);
    for (std::size_t k = 0; k < 6; ++k)
        for (std::size_t j = 0; j <= k; ++j) {
            double mean = 0, scatter = 0, gram = 0;
            for (std::size_t f = 0; f < kFrames; ++f) {
                mean += y[f * 6 + k] / double(kFrames);
                scatter += double(y[f * 6 + k]) * y[f * 6 + j];
            }
            for (std::size_t n = 0; n < kCoefficients; ++n)
                gram +=
                    double(example.cluster.basis[k * kCoefficients + n]) * example.cluster.basis[j * kCoefficients + n];
            EXPECT_NEAR(mean, 0, 1e-6);
            EXPECT_NEAR(scatter, k == j ? energies[k] : 0, 1e-4);
            EXPECT_NEAR(gram, k == j, 1e-6);
        }
}

TEST(CompressModel, ComponentsThatRepeatOthersAreGone) {
    Example example(5);
    ClusterModel& cluster = example.cluster;
    std::copy_n(cluster.basis.begin(), kCoefficients, cluster.basis.begin() + 3 * kCoefficients);
    std::fill_n(cluster.basis.begin() + 4 * kCoefficients, kCoefficients, 0.0f);
    const std::vector<double> before = example.coefficients(cluster);
    EXPECT_EQ(example.turn().size(), 3u);
    EXPECT_EQ(cluster.components(), 3u);
    const std::vector<double> after = example.coefficients(cluster);
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-5);
}

// Dropping costs the energies of what is dropped. No other rank-3 model of these predictions costs less than the
// first axes do, and certainly not the first components as they were.
TEST(CompressModel, DroppingCostsTheEnergyThatWasPredicted) {
    Example example(6), plain(6);
    const std::vector<double> before = example.coefficients(example.cluster);
    const std::vector<double> energies = example.turn();
    const auto lost = [&](const Example& of) {
        const std::vector<double> now = of.coefficients(of.cluster);
        double sum = 0;
        for (std::size_t i = 0; i < now.size(); ++i) sum += (now[i] - before[i]) * (now[i] - before[i]);
        return sum;
    };
    for (std::size_t kept = 5; kept >= 1; --kept) {
        keepComponents(example.cluster, kept);
        double predicted = 0;
        for (std::size_t k = kept; k < 6; ++k) predicted += energies[k];
        EXPECT_NEAR(lost(example), predicted, 1e-5 * predicted);
        keepComponents(plain.cluster, kept);
        EXPECT_GT(lost(plain), predicted);
    }
}

TEST(CompressModel, DropsWhatCostsLeastForItsBytes) {
    const ComponentCosts costs{{{9, 4, 1}, {8, 6}, {0.1}}, {1, 8, 1}};  // 4, 1: a byte each; 6 / 8 bytes
    EXPECT_EQ(dropForBytes(costs, 0).kept, (std::vector<std::size_t>{3, 2, 1}));
    const ComponentChoice one = dropForBytes(costs, 3);
    EXPECT_EQ(one.kept, (std::vector<std::size_t>{3, 1, 1}));
    EXPECT_EQ(one.dropped_energy, 6);
    EXPECT_EQ(one.dropped_bytes, 8);
    EXPECT_EQ(dropForBytes(costs, 9).kept, (std::vector<std::size_t>{2, 1, 1}));
    EXPECT_EQ(dropForBytes(costs, 1000).kept, (std::vector<std::size_t>{1, 1, 1})) << "one of each stays";
    EXPECT_EQ(dropForEnergy(costs, 6.9).kept, (std::vector<std::size_t>{3, 1, 1}));
    EXPECT_EQ(dropForEnergy(costs, 7.1).kept, (std::vector<std::size_t>{2, 1, 1}));
    EXPECT_EQ(dropForEnergy(costs, 0).kept, (std::vector<std::size_t>{3, 2, 1}));
}

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 12, .clusters = 4, .components = 8, .inputs = 6, .frames = 24};

Model livelyTube() {
    Model model = synthetic::tubeModel(kTube);
    synthetic::turnJointsApart(model);
    return model;
}

double bytesPerVertex(const Packed& packed) {
    const AssetView asset = openAsset(packed.bytes);
    return double(modelBytes(asset, packed.bytes.size())) / double(asset.mesh.positions.size());
}

TEST(PackWithin, MeetsTheBytesAskedForAndUsesThem) {
    const Model model = livelyTube();
    const Packed whole = packAsset(model, {}, {}, {.precision = AssetPrecision::kI8}, "{}", 2);
    const double bytes = bytesPerVertex(whole);
    double error = 0;
    for (double share : {1.01, 0.9, 0.75}) {
        const Packed packed = packAsset(model, {}, {}, {.max_bytes_per_vertex = share * bytes}, "{}", 2);
        EXPECT_LE(bytesPerVertex(packed), share * bytes);
        // A component is 16 bytes a vertex of its cluster, which is one of four.
        if (packed.components < packed.all_components) {
            EXPECT_GT(bytesPerVertex(packed), share * bytes - 8);
        }
        EXPECT_GE(packed.quantization_error, error);
        error = packed.quantization_error;
        EXPECT_FLOAT_EQ(openAsset(packed.bytes).model.quantization_error, float(error));
        // What was predicted for dropping is nearly all of the error, and rounding adds the rest.
        EXPECT_LE(packed.dropped_error, packed.quantization_error * 1.01);
        if (share < 0.8) {
            EXPECT_GT(packed.dropped_error, 0.9 * packed.quantization_error);
        }
    }
}

TEST(PackWithin, KeepsTheErrorAskedForAndUsesIt) {
    const Model model = livelyTube();
    std::size_t components = 33;
    for (double bound : {0.05, 0.2, 0.5}) {
        const Packed packed = packAsset(model, {}, {}, {.max_error = bound}, "{}", 1);
        EXPECT_LE(packed.quantization_error, bound);
        EXPECT_LT(packed.components, components);
        components = packed.components;
    }
    EXPECT_LT(components, 24u);
}

TEST(PackWithin, RefusesBoundsThatCannotBeMet) {
    const Model model = livelyTube();
    const auto refusal = [&](const PackOptions& options) {
        return refusalBy<UsageError>([&] { packAsset(model, {}, {}, options, "{}", 1); });
    };
    EXPECT_EQ(refusal({.max_error = 0.5, .max_bytes_per_vertex = 400}), "accepted");
    EXPECT_NE(refusal({.max_bytes_per_vertex = 20}).find("max_bytes_per_vertex: with one component"),
              std::string::npos);
    const double bytes = bytesPerVertex(packAsset(model, {}, {}, {.max_error = 0.3}, "{}", 1));
    const std::string both = refusal({.max_error = 0.05, .max_bytes_per_vertex = bytes});
    EXPECT_NE(both.find("within the bytes"), std::string::npos) << both;
}

// Without a bound, packing drops what does not matter; with a precision alone it drops no component.
TEST(PackWithin, DropsByDefaultWhatHardlyCounts) {
    Model model = livelyTube();
    for (ClusterModel& cluster : model.clusters)  // the last component of each cluster is next to nothing
        for (std::size_t i = 0; i < cluster.units(); ++i) cluster.weights[7 * cluster.units() + i] *= 1e-3f;
    const Packed packed = packAsset(model, {}, {}, {}, "{}", 1);
    EXPECT_LT(packed.components, packed.all_components);
    EXPECT_LE(packed.dropped_error, std::sqrt(1e-3));
    EXPECT_EQ(packAsset(model, {}, {}, {.precision = AssetPrecision::kF16}, "{}", 1).components, 32u);
}

}  // namespace
}  // namespace penumbra::test_compress_model
