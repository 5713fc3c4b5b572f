#include <gtest/gtest.h>

#include <cmath>

#include "fit/models/neural_cross_validation.h"
#include "fit/models/neural_start.h"
#include "fit/models/variable_projection.h"
#include "fit/numerics/pca.h"
#include "tests/difference.h"
#include "tests/fit/synthetic_net.h"

namespace penumbra::test_neural_cross_validation {
namespace {

using synthetic::normalMatrix;
using synthetic::normalNet;

std::vector<int> blocks(std::size_t rows, int count) {
    std::vector<int> folds;
    for (std::size_t r = 0; r < rows; ++r) folds.push_back(int(r * std::size_t(count) / rows));
    return folds;
}

double variance(const Matrix& y) {
    std::vector<std::size_t> all(y.rows);
    for (std::size_t r = 0; r < y.rows; ++r) all[r] = r;
    const std::vector<double> mean = meanOfRows(y, all);
    double sum = 0;
    for (std::size_t r = 0; r < y.rows; ++r)
        for (std::size_t c = 0; c < y.columns; ++c) sum += (y(r, c) - mean[c]) * (y(r, c) - mean[c]);
    return sum;
}

double squaredError(const Matrix& a, const Matrix& b) { return std::pow(distanceBetween(a.values, b.values), 2); }

TEST(NeuralCrossValidation, OfNoiseChoosesAPriorThatLeavesTheMean) {
    const Matrix x = normalMatrix(80, 4, 1), y = normalMatrix(80, 3, 2);
    const NetSearch search{.input_variance = 1};
    const NetChoice choice = chooseNet(x, y, blocks(80, 4), search);
    EXPECT_GE(choice.prior, 0.1);
    EXPECT_GT(choice.error, 0.99 * variance(y));
    const TanhNet net = fitChosenNet(x, y, choice, search);
    EXPECT_LT(variance(predict(net, x)), 0.01 * variance(y));
}

TEST(NeuralCrossValidation, OfANetChoosesAWeakPriorAndPredictsNewFrames) {
    const TanhNet truth = normalNet(3, 2, 4, 3);
    const Matrix x = normalMatrix(200, 3, 1), unseen = normalMatrix(100, 3, 2), y = predict(truth, x);
    const NetSearch search{.input_variance = 1};
    const NetChoice choice = chooseNet(x, y, blocks(200, 4), search);
    EXPECT_LE(choice.prior, 1e-3);
    EXPECT_LT(choice.error, 0.02 * variance(y));
    const Matrix expected = predict(truth, unseen);
    EXPECT_LT(squaredError(predict(fitChosenNet(x, y, choice, search), unseen), expected), 0.02 * variance(expected));
}

// The units of inputs and outputs change only the units of the net.
TEST(NeuralCrossValidation, DoesNotDependOnUnits) {
    Matrix x = normalMatrix(60, 3, 1), y = predict(normalNet(3, 2, 4, 3), x);
    const NetSearch search{.neurons = {4}, .input_variance = 1};
    const NetChoice before = chooseNet(x, y, blocks(60, 4), search);
    const Matrix predicted = predict(fitChosenNet(x, y, before, search), x);
    for (double& v : x.values) v *= 1024;
    for (double& v : y.values) v /= 64;
    const NetChoice after = chooseNet(x, y, blocks(60, 4), search);
    EXPECT_EQ(after.prior, before.prior);
    EXPECT_NEAR(after.error * 64 * 64, before.error, 1e-6 * before.error);
    const Matrix again = predict(fitChosenNet(x, y, after, search), x);
    for (std::size_t i = 0; i < again.values.size(); ++i) EXPECT_NEAR(again.values[i] * 64, predicted.values[i], 1e-6);
}

// Repeats the choice by hand: means, input PCA and units come from the rows that are kept, and the rows left out are
// only predicted. 8 folds of clips are merged into 4.
TEST(NeuralCrossValidation, NothingOfAFoldEnters) {
    const Matrix x = normalMatrix(80, 5, 1), y = predict(normalNet(5, 2, 4, 3), x);
    const NetSearch search{
        .neurons = {3}, .least_prior = 0.01, .most_prior = 0.01, .folds = 4, .input_variance = 0.7, .seed = 9};
    double expected = 0;
    for (int f = 0; f < 4; ++f) {
        std::vector<std::size_t> kept, out;
        for (std::size_t r = 0; r < 80; ++r) (int(r / 10) % 4 == f ? out : kept).push_back(r);
        const std::vector<double> x_mean = meanOfRows(x, kept), y_mean = meanOfRows(y, kept);
        Matrix centered(kept.size(), 5), values(kept.size(), 2);
        for (std::size_t r = 0; r < kept.size(); ++r) {
            for (std::size_t c = 0; c < 5; ++c) centered(r, c) = x(kept[r], c) - x_mean[c];
            for (std::size_t k = 0; k < 2; ++k) values(r, k) = y(kept[r], k) - y_mean[k];
        }
        const Pca pca = principalComponents(centered);
        const std::size_t count = componentsFor(pca, 0.7);
        ASSERT_LT(count, 5u);
        const Matrix basis = basisOf(pca, centered, count);
        const auto project = [&](std::span<const double> row, std::span<double> to) {
            for (std::size_t i = 0; i < count; ++i) {
                to[i] = 0;
                for (std::size_t c = 0; c < 5; ++c) to[i] += basis(i, c) * (row[c] - x_mean[c]);
            }
        };
        Matrix reduced(kept.size(), count), unseen(out.size(), count), truth(out.size(), 2);
        for (std::size_t r = 0; r < kept.size(); ++r) project(x.row(kept[r]), reduced.row(r));
        for (std::size_t r = 0; r < out.size(); ++r) {
            project(x.row(out[r]), unseen.row(r));
            for (std::size_t k = 0; k < 2; ++k) truth(r, k) = y(out[r], k) - y_mean[k];
        }
        double x_square = 0, y_square = 0;
        for (double v : reduced.values) x_square += v * v / double(kept.size());
        for (double v : values.values) y_square += v * v / double(kept.size());
        for (Matrix* m : {&reduced, &unseen})
            for (double& v : m->values) v /= std::sqrt(x_square);
        for (Matrix* m : {&values, &truth})
            for (double& v : m->values) v /= std::sqrt(y_square);
        const NetFit fit = fitByProjection(netData(reduced, values), startNet(reduced, values, 3, 9),
                                           0.01 * double(kept.size()), {.iterations = 200, .least_decrease = 1e-3});
        expected += y_square * squaredError(predict(fit.net, unseen), truth);
    }
    // Measured 2e-14, because sums are made in another order.
    EXPECT_NEAR(chooseNet(x, y, blocks(80, 8), search).error, expected, 1e-6 * expected);
}

TEST(NeuralCrossValidation, WithOneFoldLeavesTheMean) {
    const Matrix x = normalMatrix(10, 2, 1), y = normalMatrix(10, 2, 2);
    EXPECT_EQ(chooseNet(x, y, std::vector<int>(10), {}).prior, NetSearch{}.most_prior);
}

TEST(NeuralCrossValidation, SameArgumentsSameBits) {
    const Matrix x = normalMatrix(60, 4, 1), y = normalMatrix(60, 3, 2);
    const auto run = [&] {
        const NetChoice choice = chooseNet(x, y, blocks(60, 5), {});
        return fitChosenNet(x, y, choice, {}).output.values;
    };
    EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace penumbra::test_neural_cross_validation
