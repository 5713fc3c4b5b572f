#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "sh/brdf/reflection_operator.h"
#include "sh/sh_product.h"

namespace penumbra::test_reflection_operator {
namespace {

std::vector<double> someNumbers(std::size_t n, double step) {
    std::vector<double> coefficients(n);
    for (std::size_t i = 0; i < n; ++i) coefficients[i] = std::sin(step * double(i + 1));
    return coefficients;
}

// l^T M v is the integral of l v U, where v is the function that the numbers stand for and U may have any order.
TEST(ReflectionOperator, ContractsToTheTripleProduct) {
    for (const char* name : {"A4", "B3", "D5", "D6"})
        for (int order_u : {4, 5, 8}) {
            const Convention convention = parseConvention(name);
            const std::vector<double> u = someNumbers(std::size_t(coefficientCount(order_u)), 0.7),
                                      light = someNumbers(16, 1.3);
            const std::vector<double> coefficients = someNumbers(std::size_t(convention.size()), 0.4);
            const std::vector<double> m = reflectionOperator(4, convention, u);
            ASSERT_EQ(m.size(), 16 * coefficients.size());
            double sum = 0;
            for (std::size_t i = 0; i < 16; ++i)
                for (std::size_t j = 0; j < coefficients.size(); ++j)
                    sum += light[i] * m[i * coefficients.size() + j] * coefficients[j];
            const std::vector<float> single(coefficients.begin(), coefficients.end());
            std::vector<float> v(std::size_t(coefficientCount(convention.order)));
            fullCoefficients(convention, single, v);
            std::vector<double> product(u.size());
            multiply(order_u, light, 4, std::vector<double>(v.begin(), v.end()), convention.order, product);
            EXPECT_NEAR(sum, std::inner_product(u.begin(), u.end(), product.begin(), 0.0), 2e-6) << name << order_u;
        }
}

// Without mirroring, the operator is the symmetric product matrix.
TEST(ReflectionOperator, IsTheProductMatrixOnAllCoefficients) {
    const std::vector<double> u = someNumbers(49, 0.3);
    EXPECT_EQ(reflectionOperator(4, parseConvention("A4"), u), productMatrix(4, u, 7));
}

// U = 1 is the identity on the coefficients that both sides have.
TEST(ReflectionOperator, ConstantIsTheIdentity) {
    const Convention d5 = parseConvention("D5");
    const std::vector<int> indices = d5.indices();
    const std::vector<float> m = reflectionOperator(4, d5, std::vector<float>{float(std::sqrt(4 * std::numbers::pi))});
    for (int i = 0; i < 16; ++i)
        for (std::size_t j = 0; j < indices.size(); ++j)
            EXPECT_NEAR(m[std::size_t(i) * indices.size() + j], indices[j] == i ? 1 : 0, 1e-6);
}

}  // namespace
}  // namespace penumbra::test_reflection_operator
