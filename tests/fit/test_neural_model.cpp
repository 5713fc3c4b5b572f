#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "fit/models/neural_model.h"
#include "fit/models/neural_start.h"
#include "tests/fit/neural_bfgs.h"
#include "tests/fit/synthetic_net.h"

namespace penumbra::test_neural_model {
namespace {

using synthetic::normalMatrix;
using synthetic::normalNet;

TEST(NeuralModel, OneNeuronIsEquation12) {
    TanhNet net = emptyNet(2, 1, 1);
    net.hidden.values = {0.5, -2};
    net.hidden_bias = {0.25};
    net.output.values = {3};
    net.output_bias = {-1};
    Matrix x(1, 2);
    x.values = {1, 0.5};
    EXPECT_DOUBLE_EQ(predict(net, x)(0, 0), 3 * std::tanh(0.5 - 1 + 0.25) - 1);
    Matrix y(1, 1);
    y.values = {1};
    const double error = predict(net, x)(0, 0) - 1;
    EXPECT_DOUBLE_EQ(netObjective(net, x, y, 0.1), error * error + 0.1 * (0.25 + 4 + 9));
}

// Central differences with a step of 1e-6, including the rounding of an objective near 500. Measured 5e-8 for slopes up
// to 100; the bound is 20 times as wide.
TEST(NeuralModel, GradientMatchesFiniteDifferences) {
    const Matrix x = normalMatrix(20, 5, 1), y = normalMatrix(20, 3, 2);
    TanhNet net = normalNet(5, 3, 4, 3), gradient;
    const double value = netObjective(net, x, y, 0.7, gradient);
    EXPECT_DOUBLE_EQ(value, netObjective(net, x, y, 0.7));
    const auto check = [&](std::vector<double>& weights, const std::vector<double>& slopes) {
        for (std::size_t i = 0; i < weights.size(); ++i) {
            const double kept = weights[i], step = 1e-6;
            weights[i] = kept + step;
            const double above = netObjective(net, x, y, 0.7);
            weights[i] = kept - step;
            const double below = netObjective(net, x, y, 0.7);
            weights[i] = kept;
            EXPECT_NEAR(slopes[i], (above - below) / (2 * step), 1e-6) << i;
        }
    };
    check(net.hidden.values, gradient.hidden.values);
    check(net.hidden_bias, gradient.hidden_bias);
    check(net.output.values, gradient.output.values);
    check(net.output_bias, gradient.output_bias);
}

TEST(NeuralStart, SeparatesTwoFramesAndIsDeterministic) {
    const Matrix x = normalMatrix(30, 6, 1), y = normalMatrix(30, 2, 2);
    const TanhNet net = startNet(x, y, 4, 5);
    const Matrix h = activations(net, x);
    for (std::size_t n = 0; n < 4; ++n) {
        int below = 0, above = 0;  // the two frames of the pair: -1/2 and 1/2
        for (std::size_t f = 0; f < 30; ++f) {
            below += std::abs(h(f, n) + 0.5) < 1e-12;
            above += std::abs(h(f, n) - 0.5) < 1e-12;
        }
        EXPECT_GE(below, 1) << n;
        EXPECT_GE(above, 1) << n;
    }
    EXPECT_EQ(startNet(x, y, 4, 5).hidden.values, net.hidden.values);
    EXPECT_NE(startNet(x, y, 4, 6).hidden.values, net.hidden.values);
}

// Inputs that never change leave nothing for a neuron to tell apart.
TEST(NeuralStart, OfConstantInputsIsZero) {
    const TanhNet net = startNet(Matrix(10, 3), normalMatrix(10, 2, 1), 2, 1);
    for (double d : net.hidden.values) EXPECT_EQ(d, 0);
    for (double d : net.hidden_bias) EXPECT_EQ(d, 0);
}

TEST(NeuralBfgs, BothMethodsDescendToAStationaryPoint) {
    const Matrix x = normalMatrix(40, 3, 1), y = predict(normalNet(3, 2, 3, 2), x);
    TanhNet start = startNet(x, y, 3, 1), gradient;
    for (QuasiNewton method : {QuasiNewton::kBfgs, QuasiNewton::kLbfgs}) {
        const NetFit fit = fitByBfgs(x, y, start, 0.1, {method, 5000, 0});
        EXPECT_LT(fit.objective, netObjective(start, x, y, 0.1));
        EXPECT_GT(fit.iterations, 10);
        netObjective(fit.net, x, y, 0.1, gradient);
        for (const std::vector<double>* part :
             {&gradient.hidden.values, &gradient.hidden_bias, &gradient.output.values, &gradient.output_bias})
            for (double g : *part) EXPECT_NEAR(g, 0, 2e-6);  // measured 1e-7; weights and outputs are near 1
    }
}

TEST(NeuralBfgs, RefusesNumbersThatAreNotFinite) {
    Matrix x = normalMatrix(10, 2, 1);
    x(0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(fitByBfgs(x, normalMatrix(10, 1, 2), normalNet(2, 1, 2, 3), 0.1), std::runtime_error);
}

// The ends of a loop are one pose except for rounding. No neuron may start between them, because it would never move
// again.
TEST(NeuralStart, IgnoresFramesThatAreOnePose) {
    Matrix inputs(40, 2), outputs(40, 1);
    for (std::size_t f = 0; f < 40; ++f) {
        const double t = double(f % 20);
        inputs(f, 0) = std::sin(t) + (f < 20 ? 0 : 1e-13);
        inputs(f, 1) = std::cos(2 * t);
        outputs(f, 0) = std::sin(t) + (f < 20 ? 0 : 0.01);
    }
    const TanhNet net = startNet(inputs, outputs, 16, 1);
    for (std::size_t n = 0; n < 16; ++n) {
        const double size = std::hypot(net.hidden(n, 0), net.hidden(n, 1));  // log 3 / the distance of two poses
        EXPECT_LT(size, 1e4);
        EXPECT_GT(size, std::log(3) / std::hypot(2, 2) - 1e-9) << "poses are at most so far apart";
    }
}

}  // namespace
}  // namespace penumbra::test_neural_model
