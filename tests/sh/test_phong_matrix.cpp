#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sh/brdf/phong_matrix.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "tests/sh/golden.h"

namespace penumbra::test_phong_matrix {
namespace {

TEST(PhongMatrix, MatchesGolden) {
    const auto golden = readGolden("phong_matrix.json");
    const std::vector<double> v = doubles(golden.at("v"));
    for (const auto& [text, test] : golden.at("values").items()) {
        const double alpha = std::stod(text);
        const std::vector<double> matrix = phongMatrix(alpha);
        expectNear(matrix, symmetricMatrix(test.at("entries"), 16), golden.at("tol"));
        std::vector<double> t(16);
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j)
                t[i] += (alpha + 1) / (2 * std::numbers::pi) * matrix[i * 16 + j] * v[j];
        expectNear(t, doubles(test.at("t")), golden.at("tol"));
    }
}

// The closed forms hold between integers too. z^2.7 is not a polynomial, so 200 nodes come within 1e-12.
TEST(PhongMatrix, IsTheIntegral) {
    std::vector<double> sums(256), y(16);
    for (const auto& [direction, weight] : gaussHemisphere(200, 16)) {
        evalBasis(4, direction, y);
        for (std::size_t i = 0; i < 256; ++i) sums[i] += weight * std::pow(direction.z, 2.7) * y[i / 16] * y[i % 16];
    }
    expectNear(phongMatrix(2.7), sums, 1e-12);
}

TEST(PhongMatrix, HasFortyFourEntries) {
    const auto nonZeros = [](double alpha) {
        int count = 0;
        for (double value : phongMatrix(alpha)) count += std::abs(value) > 1e-15;
        return count;
    };
    EXPECT_EQ(nonZeros(10), 44);
    EXPECT_EQ(nonZeros(1), 42);  // M_0C is proportional to alpha - 1
}

}  // namespace
}  // namespace penumbra::test_phong_matrix
