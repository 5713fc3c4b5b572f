#include "sh/quaternion.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

Quaternion multiply(const Quaternion& a, const Quaternion& b) {
    return {
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

Quaternion conjugate(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }

namespace {

double norm(const Quaternion& q) { return std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]); }

}  // namespace

std::optional<Quaternion> normalized(const Quaternion& q) {
    const double n = norm(q);
    if (!std::isfinite(n) || n < 1e-20) return std::nullopt;
    return Quaternion{q[0] / n, q[1] / n, q[2] / n, q[3] / n};
}

Quaternion slerp(const Quaternion& a, const Quaternion& b, double t) {
    Quaternion sum, difference;
    const double sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
    for (std::size_t i = 0; i < 4; ++i) {
        sum[i] = a[i] + sign * b[i];
        difference[i] = a[i] - sign * b[i];
    }
    // Half the angle comes from the two chords. It is exact to rounding for small angles, where acos is not.
    const double angle = 2 * std::atan2(norm(difference), norm(sum));
    const double s = std::sin(angle);
    const double from = s < 1e-12 ? 1 - t : std::sin((1 - t) * angle) / s;
    const double to = sign * (s < 1e-12 ? t : std::sin(t * angle) / s);
    Quaternion q;
    for (std::size_t i = 0; i < 4; ++i) q[i] = from * a[i] + to * b[i];
    return normalized(q).value_or(a);
}

Vec3d rotationVector(const Quaternion& q) {
    const double sign = q[3] < 0 ? -1 : 1;  // q and -q are one rotation; w >= 0 has the angle <= pi
    const Vec3d v = sign * Vec3d{q[0], q[1], q[2]};
    const double s = length(v);
    if (s < 1e-12) return 2.0 * v;
    return (2 * std::atan2(s, sign * q[3]) / s) * v;
}

Quaternion rotationOf(Vec3d v) {
    const double angle = length(v);
    const double s = angle < 1e-12 ? 0.5 : std::sin(angle / 2) / angle;
    return {s * v.x, s * v.y, s * v.z, std::cos(angle / 2)};
}

// Shepperd's method divides by the largest of w, x, y and z.
Quaternion quaternionOf(const Mat3d& m) {
    const double trace = m(0, 0) + m(1, 1) + m(2, 2);
    const std::array<double, 4> size{m(0, 0), m(1, 1), m(2, 2), trace};
    const int largest = int(std::max_element(size.begin(), size.end()) - size.begin());
    Quaternion q;
    if (largest == 3) {
        q = {m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1), 1 + trace};
    } else {
        const int i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
        q[std::size_t(i)] = 1 + 2 * m(i, i) - trace;
        q[std::size_t(j)] = m(i, j) + m(j, i);
        q[std::size_t(k)] = m(i, k) + m(k, i);
        q[3] = m(k, j) - m(j, k);
    }
    return normalized(q).value_or(Quaternion{0, 0, 0, 1});
}

Mat3d matrixOf(const Quaternion& q) {
    const auto [x, y, z, w] = q;
    return {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
             2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),  //
             2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
}

}  // namespace penumbra
