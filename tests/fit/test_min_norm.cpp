#include <gtest/gtest.h>

#include <cmath>

#include "fit/numerics/min_norm.h"
#include "fit/numerics/minimise_directions.h"

namespace penumbra {
namespace {

SmallMatrix filled(int rows, int columns, double salt) {
    SmallMatrix m{rows, columns, {}};
    for (std::size_t j = 0; j < std::size_t(columns); ++j)
        for (std::size_t i = 0; i < std::size_t(rows); ++i)
            m.at[j][i] = std::sin(salt + 1.7 * double(i) + 2.9 * double(j * j));
    return m;
}

// Returns entry (i, c) of a x - b.
double residual(const SmallMatrix& a, const SmallMatrix& x, const SmallMatrix& b, std::size_t i, std::size_t c) {
    double sum = -b.at[c][i];
    for (std::size_t j = 0; j < std::size_t(a.columns); ++j) sum += a.at[j][i] * x.at[c][j];
    return sum;
}

// For a tall matrix the residual is orthogonal to every column. For a wide one there is no residual, and x is a sum of
// rows, which makes it the shortest.
TEST(MinNorm, SolvesTheNormalEquations) {
    for (const auto& [rows, columns] : {std::pair{7, 3}, {15, 15}, {9, 1}, {3, 7}, {1, 15}}) {
        const SmallMatrix a = filled(rows, columns, 0.3), b = filled(rows, 3, 5);
        const SmallMatrix x = solveMinNorm(a, b, 0);
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t j = 0; j < std::size_t(columns); ++j) {
                double along = 0;
                for (std::size_t i = 0; i < std::size_t(rows); ++i) along += a.at[j][i] * residual(a, x, b, i, c);
                EXPECT_NEAR(along, 0, 1e-11) << rows << " x " << columns;
            }
    }
}

// Two equal columns share what one alone would take. That is shorter than any other split.
TEST(MinNorm, EqualColumnsShare) {
    SmallMatrix a = filled(5, 2, 1), b = filled(5, 3, 2);
    a.at[1] = a.at[0];
    SmallMatrix one = a;
    one.columns = 1;
    const SmallMatrix x = solveMinNorm(a, b, 0), single = solveMinNorm(one, b, 0);
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(x.at[c][0], single.at[c][0] / 2, 1e-14);
        EXPECT_NEAR(x.at[c][1], single.at[c][0] / 2, 1e-14);
    }
    EXPECT_EQ(solveMinNorm({3, 2, {}}, filled(3, 3, 1), 0).at[0][0], 0);  // there is nothing to solve with
}

// With a ridge, a^T (a x - b) + ridge x = 0.
TEST(MinNorm, RidgeIsInTheNormalEquations) {
    const SmallMatrix a = filled(7, 4, 0.7), b = filled(7, 3, 4);
    const SmallMatrix x = solveMinNorm(a, b, 0.25);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t j = 0; j < 4; ++j) {
            double sum = 0.25 * x.at[c][j];
            for (std::size_t i = 0; i < 7; ++i) sum += a.at[j][i] * residual(a, x, b, i, c);
            EXPECT_NEAR(sum, 0, 1e-12);
        }
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
}  // namespace penumbra
