#include <gtest/gtest.h>

#include <cmath>

#include "fit/models/neural_start.h"
#include "fit/models/variable_projection.h"
#include "tests/difference.h"
#include "tests/fit/neural_bfgs.h"
#include "tests/fit/synthetic_net.h"

namespace penumbra::test_variable_projection {
namespace {

using synthetic::normalMatrix;
using synthetic::normalNet;

const SearchOptions kToTheEnd{.iterations = 3000, .least_decrease = 1e-14};

double largestGradient(const TanhNet& net, const Matrix& x, const Matrix& y, double alpha) {
    TanhNet gradient;
    netObjective(net, x, y, alpha, gradient);
    Largest largest;
    for (const std::vector<double>* part :
         {&gradient.hidden.values, &gradient.hidden_bias, &gradient.output.values, &gradient.output_bias})
        for (double g : *part) largest.add(std::abs(g));
    return largest;
}

// Rosenbrock's valley in 10 variables has its minimum 0 where all are one.
TEST(Lbfgs, FollowsACurvedValley) {
    const auto evaluate = [](std::span<const double> x, std::span<double> g) {
        double sum = 0;
        std::fill(g.begin(), g.end(), 0.0);
        for (std::size_t i = 0; i + 1 < x.size(); ++i) {
            const double a = x[i + 1] - x[i] * x[i], b = 1 - x[i];
            sum += 100 * a * a + b * b;
            g[i] += -400 * a * x[i] - 2 * b;
            g[i + 1] += 200 * a;
        }
        return sum;
    };
    std::vector<double> x(10, -1.2);
    const SearchResult result = minimise(evaluate, {.iterations = 2000, .least_decrease = 0}, x);
    EXPECT_LT(result.value, 1e-20);
    for (double v : x) EXPECT_NEAR(v, 1, 1e-9);
}

TEST(Lbfgs, StopsAtTheTarget) {
    const auto evaluate = [](std::span<const double> x, std::span<double> g) {
        g[0] = 4 * x[0] * x[0] * x[0];
        return x[0] * x[0] * x[0] * x[0];
    };
    std::vector<double> x{1.5};
    const SearchResult result = minimise(evaluate, {.target = 1e-3}, x);
    EXPECT_LE(result.value, 1e-3);
    EXPECT_GT(result.value, 1e-9);
}

// The search sees eq 13 itself, and it ends at a stationary point of eq 13 in all weights. With 41 frames the last
// lanes are padding.
TEST(VariableProjection, EndsAtAStationaryPointOfEquation13) {
    const Matrix x = normalMatrix(41, 5, 1), y = normalMatrix(41, 3, 2);
    const NetFit fit = fitByProjection(netData(x, y), startNet(x, y, 4, 1), 0.5, kToTheEnd);
    EXPECT_NEAR(fit.objective, netObjective(fit.net, x, y, 0.5), 1e-12 * fit.objective);
    EXPECT_LT(largestGradient(fit.net, x, y, 0.5), 1e-5);  // measured 2e-7; the objective is near 80
}

// The outputs are those of a net of 3 neurons. From some of 10 starts the search finds weights that predict unseen
// inputs to 1e-6 (measured 4e-12).
TEST(VariableProjection, RecoversAKnownNet) {
    const TanhNet truth = normalNet(3, 2, 3, 7);
    const Matrix x = normalMatrix(200, 3, 1), unseen = normalMatrix(50, 3, 2), y = predict(truth, x);
    NetFit best;
    best.objective = std::numeric_limits<double>::infinity();
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const NetFit fit = fitByProjection(netData(x, y), startNet(x, y, 3, seed), 1e-11, kToTheEnd);
        if (fit.objective < best.objective) best = fit;
    }
    const Matrix expected = predict(truth, unseen), found = predict(best.net, unseen);
    for (std::size_t i = 0; i < expected.values.size(); ++i) EXPECT_NEAR(found.values[i], expected.values[i], 1e-6);
}

// From one start both searches come to the same valley here, and so to the same value.
TEST(VariableProjection, AgreesWithBfgs) {
    const Matrix x = normalMatrix(60, 3, 1), y = predict(normalNet(3, 2, 2, 4), x);
    const TanhNet start = startNet(x, y, 2, 1);
    const NetFit fast = fitByProjection(netData(x, y), start, 0.3, kToTheEnd);
    const NetFit reference = fitByBfgs(x, y, fitByProjection(netData(x, y), start, 0.3, {.iterations = 0}).net, 0.3);
    EXPECT_NEAR(fast.objective, reference.objective, 1e-6 * reference.objective);
}

// More rounds only add searches. A target that any start meets ends them at once.
TEST(ManyStarts, MoreRoundsAreNeverWorseAndATargetEndsThem) {
    const Matrix x = normalMatrix(60, 6, 1), y = predict(normalNet(6, 3, 5, 2), x);
    const StartPlan once{.neurons = 5}, thrice{.neurons = 5, .rounds = 3};
    const NetFit single = fitByProjection(netData(x, y), startNet(x, y, 5, 1), 0.05, kToTheEnd);
    const NetFit one = fitFromManyStarts(x, y, 0.05, once, kToTheEnd);
    const NetFit three = fitFromManyStarts(x, y, 0.05, thrice, kToTheEnd);
    EXPECT_LE(one.objective, single.objective * 1.001);
    EXPECT_LE(three.objective, one.objective);
    EXPECT_NEAR(three.objective, netObjective(three.net, x, y, 0.05), 1e-10 * three.objective);
    SearchOptions easy = kToTheEnd;
    easy.target = 2 * three.objective;
    const NetFit early = fitFromManyStarts(x, y, 0.05, thrice, easy);
    EXPECT_LE(early.objective, easy.target);
    EXPECT_LT(early.iterations, one.iterations);
}

TEST(VariableProjection, SameArgumentsSameBits) {
    const Matrix x = normalMatrix(50, 8, 1), y = normalMatrix(50, 4, 2);
    const auto fit = [&] { return fitByProjection(netData(x, y), startNet(x, y, 6, 3), 0.2, {}); };
    const NetFit a = fit(), b = fit();
    EXPECT_EQ(a.net.hidden.values, b.net.hidden.values);
    EXPECT_EQ(a.net.output.values, b.net.output.values);
}

// A strong prior leaves only the mean of the outputs.
TEST(VariableProjection, StrongPriorLeavesTheMean) {
    const Matrix x = normalMatrix(50, 3, 1), y = normalMatrix(50, 2, 2);
    const NetFit fit = fitByProjection(netData(x, y), startNet(x, y, 4, 3), 1e6, kToTheEnd);
    const Matrix predicted = predict(fit.net, x);
    std::vector<std::size_t> all(50);
    for (std::size_t f = 0; f < 50; ++f) all[f] = f;
    const std::vector<double> mean = meanOfRows(y, all);
    for (std::size_t f = 0; f < 50; ++f)
        for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(predicted(f, k), mean[k], 1e-6);
}

}  // namespace
}  // namespace penumbra::test_variable_projection
