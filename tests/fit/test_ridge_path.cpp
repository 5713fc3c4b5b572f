#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/models/linear_model.h"
#include "fit/numerics/ridge_path.h"
#include "tests/fit/golden_matrix.h"

namespace penumbra::test_ridge_path {
namespace {

constexpr std::size_t kAll = 1000;

Matrix randomMatrix(std::size_t rows, std::size_t columns, unsigned seed) {
    std::mt19937 random{seed};
    std::normal_distribution<double> normal;
    Matrix m(rows, columns);
    for (double& x : m.values) x = 1 + normal(random);
    return m;
}

Matrix gramOf(const Matrix& m) {
    Matrix gram(m.rows, m.rows);
    for (std::size_t i = 0; i < m.rows; ++i)
        for (std::size_t j = 0; j < m.rows; ++j)
            for (std::size_t c = 0; c < m.columns; ++c) gram(i, j) += m(i, c) * m(j, c);
    return gram;
}

Matrix without(const Matrix& m, const std::vector<int>& folds, int fold, bool inside) {
    Matrix out(0, m.columns);
    for (std::size_t r = 0; r < m.rows; ++r)
        if ((folds[r] == fold) == inside) {
            out.values.insert(out.values.end(), m.row(r).begin(), m.row(r).end());
            ++out.rows;
        }
    return out;
}

// The golden file gives the leave-one-out error of a regression with an intercept, and the weights. We compute the
// first from the Gram matrix of the outputs alone.
TEST(RidgePath, MatchesGoldenFile) {
    const nlohmann::json file = readGolden("ridge_loo.json");
    const Matrix a = toMatrix(file["A"]), b = toMatrix(file["B"]), expected = toMatrix(file["X_c"]);
    const RidgeSvd svd = makeRidgeSvd(a, kAll);
    const std::vector<double> alphas{file["alpha"]};
    const double error = leaveOneOutErrors(svd, gramOf(b), alphas)[0];
    EXPECT_NEAR(std::sqrt(error / double(b.values.size())), file["loo_rmse_c"].get<double>(), file["tol"]);
    const Matrix solve = weightsOperator(svd, alphas[0]);
    // X = v solve B: the rows of `solve` add up to 0, so that the mean of B does not matter.
    for (std::size_t i = 0; i < expected.rows; ++i)
        for (std::size_t c = 0; c < expected.columns; ++c) {
            double sum = 0;
            for (std::size_t k = 0; k < svd.sigma.size(); ++k)
                for (std::size_t r = 0; r < b.rows; ++r) sum += svd.v(i, k) * solve(k, r) * b(r, c);
            EXPECT_NEAR(sum, expected(i, c), file["tol"]);
        }
}

TEST(RidgePath, FoldErrorsAreThoseOfFitsWithoutTheFold) {
    const Matrix a = randomMatrix(23, 6, 1), b = randomMatrix(23, 4, 2);
    std::vector<int> folds;
    for (int r = 0; r < 23; ++r) folds.push_back(r / 6);
    const std::vector<double> alphas{0, 0.5, 3};
    const std::vector<double> errors = foldErrors(a, gramOf(b), folds, kAll, alphas);
    for (std::size_t i = 0; i < alphas.size(); ++i) {
        double expected = 0;
        for (int f = 0; f < 4; ++f) {
            const Ridge ridge = fitRidge(without(a, folds, f, false), without(b, folds, f, false), alphas[i]);
            const Matrix truth = without(b, folds, f, true), predicted = predict(ridge, without(a, folds, f, true));
            expected += squaredDistance(truth.values, predicted.values);
        }
        EXPECT_NEAR(errors[i], expected, 1e-9 * expected) << alphas[i];
    }
}

TEST(RidgePath, LeaveOneOutIsOneFoldARow) {
    const Matrix a = randomMatrix(17, 5, 3), b = randomMatrix(17, 3, 4);
    std::vector<int> folds;
    for (int r = 0; r < 17; ++r) folds.push_back(r);
    const std::vector<double> alphas{0.1, 2};
    const std::vector<double> direct = foldErrors(a, gramOf(b), folds, kAll, alphas),
                              shortcut = leaveOneOutErrors(makeRidgeSvd(a, kAll), gramOf(b), alphas);
    for (std::size_t i = 0; i < alphas.size(); ++i) EXPECT_NEAR(shortcut[i], direct[i], 1e-9 * direct[i]);
}

TEST(RidgePath, ColumnsThatRepeatAreLeftOut) {
    Matrix a = randomMatrix(12, 3, 5);
    for (std::size_t r = 0; r < a.rows; ++r) a(r, 2) = a(r, 0) - a(r, 1);
    EXPECT_EQ(makeRidgeSvd(a, kAll).sigma.size(), 2u);
    EXPECT_EQ(makeRidgeSvd(a, 1).sigma.size(), 1u);
}

TEST(RidgePath, OneFoldGivesNoError) {
    const Matrix a = randomMatrix(5, 2, 6), b = randomMatrix(5, 2, 7);
    EXPECT_EQ(foldErrors(a, gramOf(b), std::vector<int>(5, 0), kAll, std::vector<double>{1}), std::vector<double>{0});
}

}  // namespace
}  // namespace penumbra::test_ridge_path
