#include "sh/vec3.h"

#include <algorithm>

#include "sh/quaternion.h"

namespace penumbra {

namespace {

using Mat4d = std::array<std::array<double, 4>, 4>;

// Returns Davenport's matrix of the attitude problem: q^T K q = trace(R(q)^T A) for a unit quaternion q = (w, x, y, z).
// The eigenvector of the largest eigenvalue is therefore the nearest rotation, whatever the sign of det A.
Mat4d davenport(const Mat3d& a) {
    const double s01 = a(0, 1) + a(1, 0), s02 = a(0, 2) + a(2, 0), s12 = a(1, 2) + a(2, 1);
    const double d12 = a(2, 1) - a(1, 2), d20 = a(0, 2) - a(2, 0), d01 = a(1, 0) - a(0, 1);
    return {{{a(0, 0) + a(1, 1) + a(2, 2), d12, d20, d01},
             {d12, a(0, 0) - a(1, 1) - a(2, 2), s01, s02},
             {d20, s01, a(1, 1) - a(0, 0) - a(2, 2), s12},
             {d01, s02, s12, a(2, 2) - a(0, 0) - a(1, 1)}}};
}

// Makes one Jacobi rotation that turns k[p][q] into zero. `v` collects the rotations in its columns.
void jacobiRotate(Mat4d& k, Mat4d& v, int p, int q) {
    // 1. The rotation by the smaller of the two possible angles.
    if (k[p][q] == 0) return;
    const double theta = (k[q][q] - k[p][p]) / (2 * k[p][q]);
    const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
    const double c = 1 / std::sqrt(t * t + 1), s = t * c;
    // 2. Apply it to the columns and rows of k, and to the columns of v.
    for (int i = 0; i < 4; ++i) {
        const double a = k[i][p], b = k[i][q];
        k[i][p] = c * a - s * b;
        k[i][q] = s * a + c * b;
    }
    for (int i = 0; i < 4; ++i) {
        const double a = k[p][i], b = k[q][i];
        k[p][i] = c * a - s * b;
        k[q][i] = s * a + c * b;
    }
    for (int i = 0; i < 4; ++i) {
        const double a = v[i][p], b = v[i][q];
        v[i][p] = c * a - s * b;
        v[i][q] = s * a + c * b;
    }
    k[p][q] = k[q][p] = 0;
}

// Returns the eigenvector of the largest eigenvalue, by Jacobi's method.
std::array<double, 4> largestEigenvector(Mat4d k) {
    Mat4d v{};
    for (int i = 0; i < 4; ++i) v[i][i] = 1;
    constexpr int kMaxSweeps = 16;  // 4 to 6 sweeps reach machine precision
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
        double off = 0, total = 0;
        for (int p = 0; p < 4; ++p)
            for (int q = 0; q < 4; ++q) (p == q ? total : off) += k[p][q] * k[p][q];
        if (!(off > 1e-32 * total)) break;
        for (int p = 0; p < 3; ++p)
            for (int q = p + 1; q < 4; ++q) jacobiRotate(k, v, p, q);
    }
    int best = 0;
    for (int i = 1; i < 4; ++i)
        if (k[i][i] > k[best][best]) best = i;
    return {v[0][best], v[1][best], v[2][best], v[3][best]};
}

}  // namespace

Mat3 nearestRotation(const Mat3& a) {
    double scale = 0;
    for (float value : a.m) scale = std::max(scale, std::abs(double(value)));
    Mat3d unit;
    for (int i = 0; i < 9; ++i) unit.m[i] = scale > 0 ? double(a.m[i]) / scale : 0;
    auto [w, x, y, z] = largestEigenvector(davenport(unit));
    const double n = 1 / std::sqrt(w * w + x * x + y * y + z * z);
    w *= n, x *= n, y *= n, z *= n;
    const Mat3d rotation = matrixOf({x, y, z, w});
    Mat3 out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = float(rotation.m[i]);
    return out;
}

}  // namespace penumbra
