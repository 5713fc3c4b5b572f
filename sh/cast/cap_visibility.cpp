#include "sh/cast/cap_visibility.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "sh/fixed_basis.h"
#include "sh/sh_product.h"
#include "sh/symmetric_eigen.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

constexpr double kMinEigenvalue = 0.02;  // relative to the largest; .005 to .04 give equally good shadows
constexpr double kFadeFrom = 0.85;       // distance / radius where a sphere begins to hide something
constexpr double kMinDistance = 1e-6;    // no axis can be told nearer to the center

double mostHalfSine() { return std::sin(kMaxCapAngle / 2); }

template <class T>
T sineOfCapAny(T distance, T radius) {
    if (distance >= radius) return radius / distance;
    return std::max(T(0), (distance / radius - T(kFadeFrom)) / T(1 - kFadeFrom));
}

// sin(angle / 2) for an angle up to 90 degrees, without the cancellation of sqrt((1 - cos) / 2).
template <class T>
T halfSine(T sine) {
    return sine / std::sqrt(2 + 2 * std::sqrt((1 - sine) * (1 + sine)));
}

// ln(x) / (x - 1), which is 1 at x = 1.
double logRatio(double x) {
    const double rest = x - 1;
    return std::abs(rest) < 1e-9 ? 1 - rest / 2 : std::log(x) / rest;
}

// The product matrix of a zonal function is made of blocks of equal m. This is one of them, over l, l' >= m.
struct MatrixBlock {
    std::size_t size;
    std::vector<double> values, vectors;  // after diagonalise()
};

MatrixBlock diagonalBlock(std::span<const double> matrix, int order, int m) {
    MatrixBlock block{std::size_t(order - m), {}, {}};
    for (int row = m; row < order; ++row)
        for (int column = m; column < order; ++column)
            block.values.push_back(matrix[std::size_t(shIndex(row, m) * coefficientCount(order) + shIndex(column, m))]);
    block.vectors.resize(block.values.size());
    diagonalise(block.size, block.values, block.vectors);
    return block;
}

double largestValue(const MatrixBlock& block) {
    double largest = 0;
    for (std::size_t i = 0; i < block.size; ++i) largest = std::max(largest, block.values[i * block.size + i]);
    return largest;
}

}  // namespace

float sineOfCap(float distance, float radius) { return sineOfCapAny(distance, radius); }
double sineOfCap(double distance, double radius) { return sineOfCapAny(distance, radius); }

Cap capOf(const CasterSphereD& sphere, Vec3d position) {
    const Vec3d to_center = sphere.center - position;
    const double distance = length(to_center);
    if (distance < kMinDistance || sphere.radius <= 0) return {{0, 0, 1}, 0};
    return {to_center / distance, std::asin(std::min(1.0, sineOfCap(distance, sphere.radius)))};
}

// f = U ln(D') / (D' - 1) U^T (g - 1) with M = U D U^T and D' = max(D, 0.02 max D). g - 1 is zonal, so only the block
// m = 0 counts, but the largest eigenvalue is that of all blocks.
void capLogZonal(double angle, std::span<double> z) {
    const int order = int(z.size());
    const std::size_t n = z.size();
    assert(order >= kMinLogOrder && order <= kMaxLogOrder && angle <= kMaxCapAngle + 1e-9);
    std::fill(z.begin(), z.end(), 0.0);
    if (angle <= 0) return;
    std::vector<double> cap(n), g(n * n);
    capVisibilityZonal(angle, cap);
    for (int l = 0; l < order; ++l) g[std::size_t(shIndex(l, 0))] = cap[std::size_t(l)];
    const std::vector<double> matrix = productMatrix(order, g, order);
    const MatrixBlock zonal = diagonalBlock(matrix, order, 0);
    double largest = largestValue(zonal);
    for (int m = 1; m < order; ++m) largest = std::max(largest, largestValue(diagonalBlock(matrix, order, m)));
    cap[0] -= std::sqrt(4 * std::numbers::pi);
    for (std::size_t j = 0; j < n; ++j) {
        double along = 0;
        for (std::size_t l = 0; l < n; ++l) along += zonal.vectors[j * n + l] * cap[l];
        along *= logRatio(std::max(zonal.values[j * n + j], kMinEigenvalue * largest));
        for (std::size_t l = 0; l < n; ++l) z[l] += along * zonal.vectors[j * n + l];
    }
}

namespace {

template <class T>
BasicCapLogTable<T> makeCapLogTable(int order) {
    BasicCapLogTable<T> table;
    table.order = order;
    std::vector<double> z(std::size_t(order), 0.0);
    for (std::size_t e = 0; e < kCapLogEntries; ++e) {
        const double u = double(e) / (kCapLogEntries - 1) * mostHalfSine();
        capLogZonal(2 * std::asin(u), z);
        for (std::size_t l = 0; l < z.size(); ++l)
            table.rows[e][l] = T(std::sqrt(4 * std::numbers::pi / double(2 * l + 1)) * z[l]);
    }
    return table;
}

template <class T>
const BasicCapLogTable<T>& cachedCapLogTable(int order) {
    assert(order >= kMinLogOrder && order <= kMaxLogOrder);
    switch (order) {
        case 3: {
            static const BasicCapLogTable<T> table = makeCapLogTable<T>(3);
            return table;
        }
        case 4: {
            static const BasicCapLogTable<T> table = makeCapLogTable<T>(4);
            return table;
        }
        case 5: {
            static const BasicCapLogTable<T> table = makeCapLogTable<T>(5);
            return table;
        }
        default: {
            static const BasicCapLogTable<T> table = makeCapLogTable<T>(6);
            return table;
        }
    }
}

// Adds the logarithm of one cap to out[Order^2]. entry = u / u_max 511.
template <int Order, class T>
void addCapLog(const BasicCapLogTable<T>& table, BasicVec3<T> axis, T entry, T* out) {
    const std::size_t e = std::min(std::size_t(entry), kCapLogEntries - 2);
    const T part = entry - T(e);
    const T *low = table.rows[e].data(), *high = table.rows[e + 1].data();
    T y[coefficientCount(Order)];
    evalBasisFixed<Order>(axis, y);
    for (int l = 0; l < Order; ++l) {
        const T z = low[l] + part * (high[l] - low[l]);
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) out[i] += z * y[i];
    }
}

template <int Order, class T>
void netLogOfSpheres(const BasicCapLogTable<T>& table, std::span<const BasicCasterSphere<T>> spheres,
                     BasicVec3<T> position, std::span<T> out) {
    const T per_entry = T((kCapLogEntries - 1) / mostHalfSine());
    T sum[coefficientCount(Order)] = {};
    for (const BasicCasterSphere<T>& sphere : spheres) {
        const BasicVec3<T> to_center = sphere.center - position;
        const T distance = std::sqrt(dot(to_center, to_center));
        if (!(distance >= T(kMinDistance)) || sphere.radius <= 0) continue;
        const T sine = std::min(T(1), sineOfCapAny(distance, sphere.radius));
        if (sine <= 0) continue;
        addCapLog<Order>(table, to_center * (1 / distance), halfSine(sine) * per_entry, sum);
    }
    std::copy_n(sum, coefficientCount(Order), out.data());
}

template <class T>
void netLogAny(const BasicCapLogTable<T>& table, std::span<const BasicCasterSphere<T>> spheres, BasicVec3<T> position,
               std::span<T> out) {
    assert(int(out.size()) == coefficientCount(table.order));
    switch (table.order) {
        case 3:
            return netLogOfSpheres<3>(table, spheres, position, out);
        case 4:
            return netLogOfSpheres<4>(table, spheres, position, out);
        case 5:
            return netLogOfSpheres<5>(table, spheres, position, out);
        default:
            return netLogOfSpheres<6>(table, spheres, position, out);
    }
}

}  // namespace

const CapLogTable& capLogTable(int order) { return cachedCapLogTable<float>(order); }
const CapLogTableD& capLogTableD(int order) { return cachedCapLogTable<double>(order); }

void netLog(const CapLogTable& table, std::span<const CasterSphere> spheres, Vec3 position, std::span<float> out) {
    netLogAny(table, spheres, position, out);
}
void netLog(const CapLogTableD& table, std::span<const CasterSphereD> spheres, Vec3d position, std::span<double> out) {
    netLogAny(table, spheres, position, out);
}

void netLog(const CapLogTableD& table, std::span<const Cap> caps, std::span<double> out) {
    assert(int(out.size()) == coefficientCount(table.order));
    std::array<double, coefficientCount(kMaxLogOrder)> sum{};
    for (const Cap& cap : caps) {
        const double entry = std::sin(std::min(cap.angle, kMaxCapAngle) / 2) / mostHalfSine() * (kCapLogEntries - 1);
        switch (table.order) {
            case 3:
                addCapLog<3>(table, cap.axis, entry, sum.data());
                break;
            case 4:
                addCapLog<4>(table, cap.axis, entry, sum.data());
                break;
            case 5:
                addCapLog<5>(table, cap.axis, entry, sum.data());
                break;
            default:
                addCapLog<6>(table, cap.axis, entry, sum.data());
        }
    }
    std::copy_n(sum.begin(), out.size(), out.begin());
}

}  // namespace penumbra
