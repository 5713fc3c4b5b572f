#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "sh/mirrored_product.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"

namespace penumbra::test_mirrored_product {
namespace {

std::vector<float> someNumbers(int count, double step) {
    std::vector<float> coefficients(std::size_t(count), 0.0f);
    for (std::size_t i = 0; i < coefficients.size(); ++i) coefficients[i] = float(std::sin(step * double(i + 1)));
    return coefficients;
}

// The integral over the upper hemisphere by quadrature, in double precision. Floats come within 2e-6 of it.
TEST(MirrorAtHorizon, TakesTheUpperHemisphereTwice) {
    for (int order : {1, 2, 4, 5, 6, 8}) {
        const std::vector<float> f = someNumbers(coefficientCount(order), 0.7);
        std::vector<float> out(std::size_t(mirroredCount(order)));
        mirrorAtHorizon(order, f, out);
        std::vector<double> expected(out.size()), y(f.size());
        for (const WeightedDirection& node : gaussHemisphere(24, 48)) {
            evalBasis(order, node.direction, y);
            double value = 0;
            for (std::size_t i = 0; i < y.size(); ++i) value += f[i] * y[i];
            std::size_t e = 0;
            for (int i : evenIndices(order)) expected[e++] += 2 * node.weight * value * y[std::size_t(i)];
        }
        for (std::size_t e = 0; e < out.size(); ++e) EXPECT_NEAR(out[e], expected[e], 1e-5) << "order " << order;
    }
}

TEST(MirrorAtHorizon, LeavesAMirroredFunctionAsItIs) {
    std::vector<float> f(36), out(std::size_t(mirroredCount(6)));
    const std::vector<float> even = someNumbers(mirroredCount(6), 0.3);
    std::size_t e = 0;
    for (int i : evenIndices(6)) f[std::size_t(i)] = even[e++];
    mirrorAtHorizon(6, f, out);
    for (std::size_t i = 0; i < out.size(); ++i) EXPECT_NEAR(out[i], even[i], 1e-6);
}

// A product of mirrored functions is a product of functions over the sphere.
TEST(MultiplyMirrored, IsTheProductOverTheSphere) {
    for (auto [order_out, order_a, order_b] : {std::array{5, 5, 6}, {6, 6, 6}, {4, 4, 6}, {1, 1, 1}}) {
        const std::vector<float> a = someNumbers(mirroredCount(order_a), 0.9),
                                 b = someNumbers(mirroredCount(order_b), 0.4);
        std::vector<float> out(std::size_t(mirroredCount(order_out)));
        multiplyMirrored(order_out, a, order_a, b, order_b, out);
        const auto whole = [](const std::vector<float>& even, int order) {
            std::vector<double> all(std::size_t(coefficientCount(order)));
            std::size_t e = 0;
            for (int i : evenIndices(order)) all[std::size_t(i)] = even[e++];
            return all;
        };
        std::vector<double> expected(std::size_t(coefficientCount(order_out)));
        multiply(order_out, whole(a, order_a), order_a, whole(b, order_b), order_b, expected);
        std::size_t e = 0;
        for (int i : evenIndices(order_out)) EXPECT_NEAR(out[e++], expected[std::size_t(i)], 1e-5);
    }
}

TEST(MultiplyMirrored, WithTheConstantOneChangesNothing) {
    const std::vector<float> a = someNumbers(mirroredCount(5), 0.6);
    std::vector<float> one(std::size_t(mirroredCount(6))), out(a.size());
    one[0] = float(std::sqrt(4 * std::numbers::pi));
    multiplyMirrored(5, a, 5, one, 6, out);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(out[i], a[i], 1e-6);
}

}  // namespace
}  // namespace penumbra::test_mirrored_product
