#include <gtest/gtest.h>

#include <cmath>

#include "fit/models/linear_model.h"
#include "fit/models/trainers.h"
#include "fit/numerics/cross_validation.h"
#include "tests/fit/synthetic_net.h"

namespace penumbra::test_quadratic_model {
namespace {

using synthetic::normalMatrix;

TEST(QuadraticModel, InputsAreTheNumbersThenTheirProducts) {
    Matrix x(1, 3);
    x.values = {2, 3, 5};
    EXPECT_EQ(quadraticInputs(x).values, (std::vector<double>{2, 3, 5, 4, 6, 10, 9, 15, 25}));
}

TEST(QuadraticModel, RecoversAKnownQuadratic) {
    const auto truth = [](std::span<const double> x) { return 1 - 2 * x[0] + x[0] * x[1] + 3 * x[2] * x[2]; };
    const Matrix x = normalMatrix(60, 3, 1), unseen = normalMatrix(20, 3, 2);
    Matrix y(60, 1);
    for (std::size_t f = 0; f < 60; ++f) y(f, 0) = truth(x.row(f));
    const Ridge ridge = fitRidge(quadraticInputs(x), y, 1e-6);
    const Matrix predicted = predict(ridge, quadraticInputs(unseen));
    for (std::size_t f = 0; f < 20; ++f) EXPECT_NEAR(predicted(f, 0), truth(unseen.row(f)), 1e-9);
}

// With more columns than rows the system is solved through the rows. The normal equations hold all the same: X^T (X W -
// Y) + a^2 W = 0.
TEST(QuadraticModel, SolvesThroughTheSmallerSide) {
    const Matrix x = quadraticInputs(normalMatrix(20, 10, 1)), y = normalMatrix(20, 2, 2);
    const double alpha = 0.7;
    const Ridge ridge = fitRidge(x, y, alpha);
    const Matrix predicted = predict(ridge, x);
    ASSERT_GT(x.columns, x.rows);
    for (std::size_t k = 0; k < 2; ++k) {
        double residual = 0;
        for (std::size_t f = 0; f < 20; ++f) residual += predicted(f, k) - y(f, k);
        EXPECT_NEAR(residual, 0, 1e-10);  // the normal equation of the intercept
        for (std::size_t c = 0; c < x.columns; ++c) {
            double sum = alpha * alpha * ridge.weights(c, k);
            for (std::size_t f = 0; f < 20; ++f) sum += x(f, c) * (predicted(f, k) - y(f, k));
            EXPECT_NEAR(sum, 0, 1e-10) << c;
        }
    }
}

// The leverage of a row says how much its own output moves its prediction.
TEST(QuadraticModel, LeverageHoldsOnTheSmallerSideToo) {
    const Matrix x = quadraticInputs(normalMatrix(20, 10, 1));
    Matrix y = normalMatrix(20, 1, 2);
    const Ridge ridge = fitRidge(x, y, 0.7);
    const double before = predict(ridge, x)(3, 0);
    y(3, 0) += 1;
    EXPECT_NEAR(predict(fitRidge(x, y, 0.7), x)(3, 0) - before, ridge.leverage[3], 1e-10);
}

// Repeats each fold by hand: means, PCA and scale of the inputs and the regression on their products come from the
// other rows. 2 inputs are solved through the columns, and 8 inputs (44 columns, 36 rows) through the rows.
TEST(QuadraticModel, CrossValidationMatchesFitsByHand) {
    for (std::size_t inputs : {2, 8}) {
        const Matrix x = normalMatrix(48, inputs, 1), y = normalMatrix(48, 2, 2);
        std::vector<int> folds;
        for (int r = 0; r < 48; ++r) folds.push_back(r / 12);
        const std::vector<double> alphas = {0.1, 3};
        const Expansion expand = quadraticInputs;
        const std::vector<double> found = blockedErrors(x, y, folds, 0.9, alphas, expand);
        for (std::size_t a = 0; a < alphas.size(); ++a) {
            double expected = 0;
            for (int f = 0; f < 4; ++f) {
                std::vector<std::size_t> kept;
                for (std::size_t r = 0; r < 48; ++r)
                    if (folds[r] != f) kept.push_back(r);
                const std::vector<double> mean = meanOfRows(x, kept);
                Matrix centered(kept.size(), inputs), values(kept.size(), 2);
                for (std::size_t r = 0; r < kept.size(); ++r) {
                    for (std::size_t c = 0; c < inputs; ++c) centered(r, c) = x(kept[r], c) - mean[c];
                    for (std::size_t k = 0; k < 2; ++k) values(r, k) = y(kept[r], k);
                }
                const Pca pca = principalComponents(centered);
                const Matrix basis = basisOf(pca, centered, componentsFor(pca, 0.9));
                Matrix reduced(48, basis.rows);
                for (std::size_t r = 0; r < 48; ++r)
                    for (std::size_t i = 0; i < basis.rows; ++i)
                        for (std::size_t c = 0; c < inputs; ++c)
                            reduced(r, i) += expansionScale(pca, kept.size()) * basis(i, c) * (x(r, c) - mean[c]);
                Matrix kept_reduced(kept.size(), basis.rows);
                for (std::size_t r = 0; r < kept.size(); ++r)
                    for (std::size_t i = 0; i < basis.rows; ++i) kept_reduced(r, i) = reduced(kept[r], i);
                const Matrix predicted =
                    predict(fitRidge(quadraticInputs(kept_reduced), values, alphas[a]), quadraticInputs(reduced));
                for (std::size_t r = 0; r < 48; ++r)
                    for (std::size_t k = 0; k < 2 && folds[r] == f; ++k)
                        expected += (predicted(r, k) - y(r, k)) * (predicted(r, k) - y(r, k));
            }
            EXPECT_NEAR(found[a], expected, 1e-8 * expected);
        }
    }
}

}  // namespace
}  // namespace penumbra::test_quadratic_model
