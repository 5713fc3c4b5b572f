#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/numerics/pca.h"
#include "tests/difference.h"

namespace penumbra::test_pca {
namespace {

// Returns centered rows with column scales 1, 1/2, 1/3, ...
template <class T>
BasicMatrix<T> decayingRows(std::size_t rows, std::size_t columns) {
    std::mt19937 random{3};
    std::normal_distribution<double> normal;
    BasicMatrix<T> m(rows, columns);
    for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t c = 0; c < columns; ++c) m(r, c) = T(normal(random) / double(c + 1));
    for (std::size_t c = 0; c < columns; ++c) {
        double mean = 0;
        for (std::size_t r = 0; r < rows; ++r) mean += m(r, c) / double(rows);
        for (std::size_t r = 0; r < rows; ++r) m(r, c) -= T(mean);
    }
    return m;
}

struct Residual {
    Largest largest;
    double energy = 0;
};

template <class T>
Residual afterComponents(const BasicMatrix<T>& rows, const Pca& pca, std::size_t count) {
    const BasicMatrix<T> basis = basisOf(pca, rows, count);
    Residual left;
    for (std::size_t r = 0; r < rows.rows; ++r)
        for (std::size_t c = 0; c < rows.columns; ++c) {
            double sum = rows(r, c);
            for (std::size_t k = 0; k < count; ++k) sum -= pca.scores(r, k) * basis(k, c);
            left.largest.add(std::abs(sum));
            left.energy += sum * sum;
        }
    return left;
}

TEST(Pca, AllComponentsReproduceTheRows) {
    for (auto [n, d] : {std::pair<std::size_t, std::size_t>{12, 40}, {40, 12}}) {
        const Matrix rows = decayingRows<double>(n, d);
        const Pca pca = principalComponents(rows);
        EXPECT_EQ(pca.energies.size(), std::min(n - 1, d));
        EXPECT_LT(afterComponents(rows, pca, pca.energies.size()).largest, 1e-12) << n << " rows";
    }
    const MatrixF rows = decayingRows<float>(12, 1500);  // a basis in float
    const Pca pca = principalComponents(rows);
    EXPECT_LT(afterComponents(rows, pca, pca.energies.size()).largest, 2e-6);
}

TEST(Pca, KeepsTheAskedFractionAndNoMore) {
    const Matrix rows = decayingRows<double>(50, 20);
    const Pca pca = principalComponents(rows);
    for (double fraction : {0.3, 0.9, 0.95, 0.999}) {
        const std::size_t count = componentsFor(pca, fraction);
        const double may_be_left = (1 - fraction) * pca.total;
        EXPECT_LE(afterComponents(rows, pca, count).energy, may_be_left * (1 + 1e-9)) << fraction;
        if (count > 1) {
            EXPECT_GT(afterComponents(rows, pca, count - 1).energy, may_be_left * (1 - 1e-9)) << fraction;
        }
    }
    EXPECT_EQ(componentsFor(pca, 1), pca.energies.size());
}

TEST(Pca, BasisIsOrthonormalAndSignsAreFixed) {
    const Matrix rows = decayingRows<double>(15, 30);
    const Pca pca = principalComponents(rows);
    const Matrix basis = basisOf(pca, rows, pca.energies.size());
    for (std::size_t a = 0; a < basis.rows; ++a) {
        for (std::size_t b = 0; b < basis.rows; ++b) {
            double product = 0;
            for (std::size_t c = 0; c < basis.columns; ++c) product += basis(a, c) * basis(b, c);
            EXPECT_NEAR(product, a == b ? 1 : 0, 1e-10);
        }
        double largest = 0;
        for (std::size_t r = 0; r < rows.rows; ++r)
            if (std::abs(pca.scores(r, a)) > std::abs(largest)) largest = pca.scores(r, a);
        EXPECT_GT(largest, 0) << "component " << a;
    }
}

TEST(Pca, RowsWithoutVarianceGiveOneZeroComponent) {
    const Matrix rows(5, 3);
    const Pca pca = principalComponents(rows);
    EXPECT_TRUE(pca.energies.empty());
    EXPECT_EQ(componentsFor(pca, 0.95), 1u);
    for (double x : basisOf(pca, rows, 1).values) EXPECT_EQ(x, 0);
}

TEST(PrincipalAxes, OfABoxAreItsEdges) {
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i) corners.push_back({(i & 1) ? 1.f : -1.f, (i & 2) ? 3.f : -3.f, (i & 4) ? 2.f : -2.f});
    const std::array<Vec3d, 3> axes = principalAxes(corners);
    EXPECT_NEAR(axes[0].y, 1, 1e-12);
    EXPECT_NEAR(axes[1].z, 1, 1e-12);
    EXPECT_NEAR(axes[2].x, 1, 1e-12);
}

}  // namespace
}  // namespace penumbra::test_pca
