#include "sh/sh_rotation.h"

#include <algorithm>
#include <cassert>

#include "sh/constexpr_sqrt.h"

namespace penumbra {

namespace {

// The recurrence of Ivanic and Ruedenberg 1996 (with the 1998 additions and corrections), rearranged by rows. Row m of
// band l is
//   R_l[m][n] = g_l[n] sum over i in {-1,0,1} of P_i(T_i, n),   T_i = a combination of at most two rows of band l-1,
//   P_i(T, n) = r_i0 T[n] for |n| < l;  r_i,1 T[l-1] - r_i,-1 T[1-l] for n = l;  r_i,1 T[1-l] + r_i,-1 T[l-1], n = -l,
// where r is band 1. It holds with the Condon-Shortley sign as well as without it: both sides change by (-1)^(m+n).
template <class T>
struct RowTerm {
    T factor = 0;
    int row = 0;  // row of band l-1, 0 .. 2l-2
};
template <class T>
struct RowRecipe {
    RowTerm<T> same;              // T_0
    RowTerm<T> plus_a, plus_b;    // T_1
    RowTerm<T> minus_a, minus_b;  // T_-1
};
template <class T>
struct BandRecipe {
    std::array<RowRecipe<T>, 2 * kMaxOrder - 1> rows{};
    std::array<T, 2 * kMaxOrder - 1> column_scale{};  // g_l
};

template <class T>
constexpr RowTerm<T> makeTerm(int l, int row, double factor) {
    if (row < -(l - 1) || row > l - 1) return {};  // the formula's factor is zero there
    return {T(factor), row + l - 1};
}

// Computes u, v and w of the paper without the column's part, and assigns them to the rows that they multiply.
template <class T>
constexpr RowRecipe<T> makeRow(int l, int m) {
    const int a = m < 0 ? -m : m;
    const double u = constexprSqrt((l + m) * (l - m)), root2 = constexprSqrt(2);
    const double v = constexprSqrt((l + a - 1) * (l + a)) / 2;
    const double w = m == 0 ? 0 : -constexprSqrt((l - a - 1) * (l - a)) / 2;
    RowRecipe<T> row;
    row.same = makeTerm<T>(l, m, u);
    if (m > 0) {
        row.plus_a = makeTerm<T>(l, m - 1, m == 1 ? root2 * v : v);
        row.minus_a = makeTerm<T>(l, -m + 1, m == 1 ? 0 : -v);
        row.plus_b = makeTerm<T>(l, m + 1, w);
        row.minus_b = makeTerm<T>(l, -m - 1, w);
    } else if (m < 0) {
        row.plus_a = makeTerm<T>(l, m + 1, m == -1 ? 0 : v);
        row.minus_a = makeTerm<T>(l, -m - 1, m == -1 ? root2 * v : v);
        row.plus_b = makeTerm<T>(l, m - 1, w);
        row.minus_b = makeTerm<T>(l, -m + 1, -w);
    } else {
        row.plus_a = makeTerm<T>(l, 1, -root2 * v);
        row.minus_a = makeTerm<T>(l, -1, -root2 * v);
    }
    return row;
}

template <class T>
constexpr std::array<BandRecipe<T>, kMaxOrder> makeRecipes() {
    std::array<BandRecipe<T>, kMaxOrder> recipes{};
    for (int l = 2; l < kMaxOrder; ++l)
        for (int m = -l; m <= l; ++m) {
            recipes[l].rows[m + l] = makeRow<T>(l, m);
            recipes[l].column_scale[m + l] =
                T(1 / constexprSqrt(m == l || m == -l ? 2 * l * (2 * l - 1) : (l + m) * (l - m)));
        }
    return recipes;
}

template <class T>
constexpr std::array<BandRecipe<T>, kMaxOrder> kRecipes = makeRecipes<T>();

// Computes band L from band L-1 (`before`). r is band 1, row-major, with rows and columns m = -1, 0, 1. All loops have
// fixed bounds.
template <int L, class T>
void makeBand(const T* r, const T* before, T* out) {
    constexpr int kWidth = 2 * L + 1, kInner = 2 * L - 1;
    const BandRecipe<T>& recipe = kRecipes<T>[L];
    const T* scale = recipe.column_scale.data();
    // 1. The inner columns take one entry of each row.
    for (int m = 0; m < kWidth; ++m) {
        const RowRecipe<T>& row = recipe.rows[m];
        const auto start = [before](const RowTerm<T>& term) { return before + term.row * kInner; };
        const T *same = start(row.same), *pa = start(row.plus_a), *pb = start(row.plus_b), *ma = start(row.minus_a),
                *mb = start(row.minus_b);
        const T fs = row.same.factor, fpa = row.plus_a.factor, fpb = row.plus_b.factor, fma = row.minus_a.factor,
                fmb = row.minus_b.factor;
        T* to = out + m * kWidth;
        for (int n = 0; n < kInner; ++n)
            to[n + 1] = scale[n + 1] *
                        (r[4] * fs * same[n] + r[7] * (fpa * pa[n] + fpb * pb[n]) + r[1] * (fma * ma[n] + fmb * mb[n]));
        // 2. The two outer columns take the first and the last entry of each row.
        const auto ends = [&](int n) {
            return std::array<T, 3>{fma * ma[n] + fmb * mb[n], fs * same[n], fpa * pa[n] + fpb * pb[n]};
        };
        const std::array<T, 3> first = ends(0), last = ends(kInner - 1);
        T low = 0, high = 0;
        for (int i = 0; i < 3; ++i) {
            low += r[3 * i + 2] * first[i] + r[3 * i] * last[i];
            high += r[3 * i + 2] * last[i] - r[3 * i] * first[i];
        }
        to[0] = scale[0] * low;
        to[kWidth - 1] = scale[kWidth - 1] * high;
    }
}

template <int L, class T>
void makeBandsFrom(int order, const T* r, T* before) {
    if constexpr (L < kMaxOrder) {
        if (L >= order) return;
        T* out = before + (2 * L - 1) * (2 * L - 1);
        makeBand<L>(r, before, out);
        makeBandsFrom<L + 1>(order, r, out);
    }
}

template <class T>
void makeBlocks(BasicShRotation<T>& rotation, int order, const BasicMat3<T>& q) {
    assert(order >= 1 && order <= kMaxOrder);
    rotation.order = order;
    rotation.blocks[0] = 1;
    if (order < 2) return;
    T* r = rotation.blocks.data() + 1;  // P Q P^T
    const std::array<T, 9> band1{q(1, 1), -q(1, 2), q(1, 0), -q(2, 1), q(2, 2), -q(2, 0), q(0, 1), -q(0, 2), q(0, 0)};
    std::copy(band1.begin(), band1.end(), r);
    makeBandsFrom<2>(order, r, r);
}

}  // namespace

ShRotation makeShRotation(int order, const Mat3& rotation) {
    ShRotation result;
    makeBlocks(result, order, rotation);
    return result;
}

ShRotationD makeShRotation(int order, const Mat3d& rotation) {
    ShRotationD result;
    makeBlocks(result, order, rotation);
    return result;
}

namespace {

template <int L, bool kTransposed, class T>
void applyBandsFrom(int order, const T* block, const T* in, T* out) {
    if constexpr (L < kMaxOrder) {
        if (L >= order) return;
        constexpr int kWidth = 2 * L + 1;
        if constexpr (kTransposed) {
            T sum[kWidth] = {};
            for (int m = 0; m < kWidth; ++m)
                for (int n = 0; n < kWidth; ++n) sum[n] += block[m * kWidth + n] * in[m];
            for (int n = 0; n < kWidth; ++n) out[n] = sum[n];
        } else {
            for (int m = 0; m < kWidth; ++m) {
                T sum = 0;
                for (int n = 0; n < kWidth; ++n) sum += block[m * kWidth + n] * in[n];
                out[m] = sum;
            }
        }
        applyBandsFrom<L + 1, kTransposed>(order, block + kWidth * kWidth, in + kWidth, out + kWidth);
    }
}

template <bool kTransposed, class T>
void applyBlocks(const BasicShRotation<T>& r, std::span<const T> in, std::span<T> out) {
    assert(int(in.size()) == coefficientCount(r.order) && out.size() == in.size());
    applyBandsFrom<0, kTransposed>(r.order, r.blocks.data(), in.data(), out.data());
}

}  // namespace

void apply(const ShRotation& r, std::span<const float> in, std::span<float> out) { applyBlocks<false>(r, in, out); }
void apply(const ShRotationD& r, std::span<const double> in, std::span<double> out) { applyBlocks<false>(r, in, out); }
void applyTransposed(const ShRotation& r, std::span<const float> in, std::span<float> out) {
    applyBlocks<true>(r, in, out);
}
void applyTransposed(const ShRotationD& r, std::span<const double> in, std::span<double> out) {
    applyBlocks<true>(r, in, out);
}

}  // namespace penumbra
