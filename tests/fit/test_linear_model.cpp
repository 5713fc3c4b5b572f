#include <gtest/gtest.h>

#include "fit/models/linear_model.h"
#include "tests/fit/golden_matrix.h"

namespace penumbra::test_linear_model {
namespace {

// Compares weights, intercept, diagonal of the hat matrix and leave-one-out error with the golden file, at its own
// tolerance.
TEST(Ridge, MatchesGoldenFile) {
    const nlohmann::json golden = readGolden("ridge_loo.json");
    const double tolerance = golden["tol"];
    const Matrix a = toMatrix(golden["A"]), b = toMatrix(golden["B"]), expected = toMatrix(golden["X_c"]);
    const Ridge ridge = fitRidge(a, b, golden["alpha"]);
    ASSERT_EQ(ridge.weights.values.size(), expected.values.size());
    for (std::size_t i = 0; i < expected.values.size(); ++i)
        EXPECT_NEAR(ridge.weights.values[i], expected.values[i], tolerance) << i;
    for (std::size_t k = 0; k < b.columns; ++k)
        EXPECT_NEAR(ridge.intercept[k], golden["c_c"][k].get<double>(), tolerance) << k;
    for (std::size_t r = 0; r < a.rows; ++r)
        EXPECT_NEAR(ridge.leverage[r], golden["hat_diag_c"][r].get<double>(), tolerance) << r;
    EXPECT_NEAR(leaveOneOutError(ridge, a, b), golden["loo_rmse_c"].get<double>(), tolerance);
}

TEST(Ridge, WithoutPriorReproducesALinearFunction) {
    Matrix x(9, 2), y(9, 1);
    for (std::size_t r = 0; r < 9; ++r) {
        x(r, 0) = double(r);
        x(r, 1) = double((r * 5) % 9);
        y(r, 0) = 2 * x(r, 0) - 3 * x(r, 1) + 7;
    }
    const Ridge ridge = fitRidge(x, y, 0);
    EXPECT_NEAR(ridge.weights(0, 0), 2, 1e-12);
    EXPECT_NEAR(ridge.weights(1, 0), -3, 1e-12);
    EXPECT_NEAR(ridge.intercept[0], 7, 1e-12);
}

TEST(Ridge, StrongPriorLeavesTheMean) {
    Matrix x(4, 1), y(4, 1);
    for (std::size_t r = 0; r < 4; ++r) {
        x(r, 0) = double(r);
        y(r, 0) = double(r * r);
    }
    const Matrix predicted = predict(fitRidge(x, y, 1e6), x);
    for (std::size_t r = 0; r < 4; ++r) EXPECT_NEAR(predicted(r, 0), 3.5, 1e-9);
}

}  // namespace
}  // namespace penumbra::test_linear_model
