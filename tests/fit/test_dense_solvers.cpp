#include <gtest/gtest.h>

#include <cmath>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/minimise_directions.h"

namespace penumbra::test_dense_solvers {
namespace {

SmallMatrix filled(int rows, int columns, double salt) {
    SmallMatrix m(rows, columns);
    for (int j = 0; j < columns; ++j)
        for (int i = 0; i < rows; ++i) m(i, j) = std::sin(salt + 1.7 * i + 2.9 * j * j);
    return m;
}

// For a tall matrix the residual is orthogonal to every column. For a wide one there is no residual, and x is a sum of
// rows, which makes it the shortest. Products are lazy here, as tests/CMakeLists.txt says.
TEST(MinNorm, SolvesTheNormalEquations) {
    for (const auto& [rows, columns] : {std::pair{7, 3}, {15, 15}, {9, 1}, {3, 7}, {1, 15}}) {
        const SmallMatrix a = filled(rows, columns, 0.3), b = filled(rows, 3, 5);
        const SmallMatrix residual = a.lazyProduct(solveMinNorm(a, b)) - b;
        const SmallMatrix left = a.transpose().lazyProduct(residual);
        EXPECT_LT(left.norm(), 1e-11) << rows << " x " << columns;
    }
}

// Two equal columns share what one alone would take. That is shorter than any other split.
TEST(MinNorm, EqualColumnsShare) {
    SmallMatrix a = filled(5, 2, 1);
    a.col(1) = a.col(0);
    const SmallMatrix b = filled(5, 3, 2), x = solveMinNorm(a, b), single = solveMinNorm(a.leftCols(1), b);
    for (int row : {0, 1}) EXPECT_LT((x.row(row) - single.row(0) / 2).norm(), 1e-14);
    EXPECT_EQ(solveMinNorm(SmallMatrix::Zero(3, 2), filled(3, 3, 1)).norm(), 0);  // there is nothing to solve with
}

// The sum of 1 - s.axis has its minimum where every direction is its axis, which is a quarter turn away here.
TEST(MinimiseDirections, FindsTheAxes) {
    const std::vector<Vec3d> axes = {{0, 0, 1}, normalized(Vec3d{1, -2, 3})},
                             start = {{1, 0, 0}, normalized(Vec3d{3, 1, 1})};
    const auto objective = [&](std::span<const Vec3d> s, std::span<Vec3d> gradient) {
        double sum = 0;
        for (std::size_t d = 0; d < s.size(); ++d) {
            sum += 1 - dot(s[d], axes[d]);
            if (!gradient.empty()) gradient[d] = -(axes[d] - dot(axes[d], s[d]) * s[d]);
        }
        return sum;
    };
    const DirectionMinimum found = minimiseOverDirections(objective, start);
    EXPECT_NEAR(found.value, 0, 1e-9);
    for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(length(found.directions[d] - axes[d]), 0, 1e-5);
}

}  // namespace
}  // namespace penumbra::test_dense_solvers
