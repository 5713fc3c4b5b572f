#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/models/net_kernels.h"

namespace penumbra::test_net_kernels {
namespace {

std::vector<double> noise(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<double> values(count);
    for (double& v : values) v = double(random()) / 4294967296.0 - 0.5;
    return values;
}

// In any order, sums of up to 61 products below 1/4 differ by less than 1e-15. The bound is 10 times as wide. The sizes
// cover whole tiles and every remainder.
TEST(NetKernels, ProductsMatchPlainLoops) {
    for (const NetKernels& path : netKernelPaths())
        for (auto [rows, inner, stride] : {std::array<std::size_t, 3>{1, 1, 4}, {4, 3, 8}, {7, 61, 36}, {10, 5, 20}}) {
            const std::vector<double> a = noise(rows * (inner + 1), 1), b = noise(inner * stride, 2);
            std::vector<double> out = noise(rows * stride, 3), inners(rows * (inner + 2), 9.0);
            const std::vector<double> before = out;
            path.addProduct(rows, inner, stride, a.data(), inner + 1, b.data(), out.data());
            for (std::size_t r = 0; r < rows; ++r)
                for (std::size_t f = 0; f < stride; ++f) {
                    double sum = before[r * stride + f];
                    for (std::size_t i = 0; i < inner; ++i) sum += a[r * (inner + 1) + i] * b[i * stride + f];
                    EXPECT_NEAR(out[r * stride + f], sum, 1e-14) << path.name;
                }
            path.innerProducts(rows, inner, stride, out.data(), b.data(), inners.data(), inner + 2);
            for (std::size_t r = 0; r < rows; ++r) {
                for (std::size_t i = 0; i < inner; ++i) {
                    double sum = 0;
                    for (std::size_t f = 0; f < stride; ++f) sum += out[r * stride + f] * b[i * stride + f];
                    EXPECT_NEAR(inners[r * (inner + 2) + i], sum, 1e-13) << path.name;
                }
                EXPECT_EQ(inners[r * (inner + 2) + inner], 9.0) << path.name;  // nothing beyond the columns
            }
        }
}

// Measured: 3.4e-16 over 1e5 numbers. The bound is 3 times as wide.
TEST(NetKernels, TanhMatchesTheStandardLibrary) {
    std::vector<double> z;
    for (double x = -25; x <= 25; x += 0.00317) z.push_back(x);
    for (double x : {0.0, -0.0, 1e-300, -1e-9, 19.999, 20.0, 1e3, -1e300}) z.push_back(x);
    while (z.size() % kNetLanes) z.push_back(0);
    for (const NetKernels& path : netKernelPaths()) {
        std::vector<double> h = z, slope(z.size());
        path.tanhAndSlope(h.size(), h.data(), slope.data());
        for (std::size_t i = 0; i < z.size(); ++i) {
            EXPECT_NEAR(h[i], std::tanh(z[i]), 1e-15) << path.name << " at " << z[i];
            EXPECT_NEAR(slope[i], 1 - h[i] * h[i], 1e-15) << path.name;
        }
    }
}

}  // namespace
}  // namespace penumbra::test_net_kernels
