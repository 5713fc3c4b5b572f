// Least squares of small matrices by one-sided Jacobi.
//
// Problem: minimise |a x - b|^2 + ridge |x|^2 for an `a` that may have any rank, with the shortest x if there are
// several.
//
// Naive: solve the normal equations (a^T a + ridge) x = a^T b. They square the condition number, and without a ridge
// they are singular when columns of `a` depend on one another.
//
// Here: turn the columns of `a` in pairs until all are orthogonal, a V = U S (Hestenes 1958). The singular values are
// then the lengths of the columns, so small ones come out accurately and those that count as zero can be left out. The
// matrices are at most 15 x 15, where this costs little. docs/formulas.md, section 6, uses it for lobes of light.

#include "fit/numerics/min_norm.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

using Column = std::array<double, kMaxMinNorm>;

double dot(const Column& a, const Column& b, int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += a[std::size_t(i)] * b[std::size_t(i)];
    return sum;
}

// Turns columns a and b in their plane.
void rotate(Column& a, Column& b, int n, double cosine, double sine) {
    for (std::size_t i = 0; i < std::size_t(n); ++i) {
        const double before = a[i];
        a[i] = cosine * before - sine * b[i];
        b[i] = sine * before + cosine * b[i];
    }
}

// Turns all pairs of columns of `a` once, and those of `v` with them. Repeated sweeps lead to a V = U S with orthogonal
// columns. Returns false when the sweep changed nothing.
bool sweep(SmallMatrix& a, SmallMatrix& v) {
    constexpr double kOrthogonal = 1e-15;
    bool turned = false;
    for (std::size_t p = 0; p + 1 < std::size_t(a.columns); ++p)
        for (std::size_t q = p + 1; q < std::size_t(a.columns); ++q) {
            // 1. A pair is orthogonal when its inner product is tiny compared with its lengths.
            const double pp = dot(a.at[p], a.at[p], a.rows), qq = dot(a.at[q], a.at[q], a.rows),
                         pq = dot(a.at[p], a.at[q], a.rows);
            if (std::abs(pq) <= kOrthogonal * std::sqrt(pp * qq)) continue;
            // 2. Otherwise turn it by the smaller of the two angles that make it orthogonal.
            const double zeta = (qq - pp) / (2 * pq);
            const double tangent = std::copysign(1 / (std::abs(zeta) + std::hypot(1.0, zeta)), zeta);
            const double cosine = 1 / std::hypot(1.0, tangent);
            rotate(a.at[p], a.at[q], a.rows, cosine, cosine * tangent);
            rotate(v.at[p], v.at[q], v.rows, cosine, cosine * tangent);
            turned = true;
        }
    return turned;
}

}  // namespace

SmallMatrix solveMinNorm(const SmallMatrix& a, const SmallMatrix& b, double ridge) {
    assert(a.rows == b.rows && a.rows <= kMaxMinNorm && a.columns <= kMaxMinNorm);
    constexpr double kRank = 1e-9;
    constexpr int kMostSweeps = 30;  // convergence is quadratic: 4 to 8 sweeps are usual
    // 1. Make the columns orthogonal: u = a v.
    SmallMatrix u = a, v{a.columns, a.columns, {}}, x{a.columns, b.columns, {}};
    for (std::size_t j = 0; j < std::size_t(a.columns); ++j) v.at[j][j] = 1;
    for (int i = 0; i < kMostSweeps && sweep(u, v); ++i) continue;
    // 2. The squared singular values are the squared lengths of the columns.
    double largest = 0;
    Column square{};
    for (std::size_t j = 0; j < std::size_t(a.columns); ++j) {
        square[j] = dot(u.at[j], u.at[j], u.rows);
        largest = std::max(largest, square[j]);
    }
    // 3. x = sum over singular values of v_j (u_j . b) / (s_j^2 + ridge); u_j has the length s_j.
    for (std::size_t j = 0; j < std::size_t(a.columns); ++j) {
        if (!(square[j] > kRank * kRank * largest)) continue;
        for (std::size_t c = 0; c < std::size_t(b.columns); ++c) {
            const double along = dot(u.at[j], b.at[c], u.rows) / (square[j] + ridge);
            for (std::size_t i = 0; i < std::size_t(x.rows); ++i) x.at[c][i] += along * v.at[j][i];
        }
    }
    return x;
}

}  // namespace penumbra
