#include "formats/rig_matrix.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

Matrix multiply(const Matrix& a, const Matrix& b) {
    Matrix c;
    for (std::size_t r = 0; r < 12; r += 4) {
        for (std::size_t k = 0; k < 4; ++k) c[r + k] = a[r] * b[k] + a[r + 1] * b[4 + k] + a[r + 2] * b[8 + k];
        c[r + 3] += a[r + 3];
    }
    return c;
}

Vec3d transformPoint(const Matrix& a, Vec3d p) {
    return {a[0] * p.x + a[1] * p.y + a[2] * p.z + a[3], a[4] * p.x + a[5] * p.y + a[6] * p.z + a[7],
            a[8] * p.x + a[9] * p.y + a[10] * p.z + a[11]};
}

static std::array<Vec3d, 3> linearRows(const Matrix& a) {
    return {Vec3d{a[0], a[1], a[2]}, Vec3d{a[4], a[5], a[6]}, Vec3d{a[8], a[9], a[10]}};
}

double determinant(const Matrix& a) {
    const auto [r0, r1, r2] = linearRows(a);
    return dot(r0, cross(r1, r2));
}

std::optional<Matrix> inverse(const Matrix& a) {
    const auto [r0, r1, r2] = linearRows(a);
    const double det = determinant(a);
    // |det| is at most the product of the row lengths (Hadamard); far below it, the rows are dependent.
    if (!(std::abs(det) > 1e-12 * length(r0) * length(r1) * length(r2))) return std::nullopt;
    const std::array<Vec3d, 3> columns{cross(r1, r2) / det, cross(r2, r0) / det, cross(r0, r1) / det};
    Matrix b;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) b[std::size_t(4 * r + c)] = columns[std::size_t(c)][r];
        b[std::size_t(4 * r + 3)] = -(columns[0][r] * a[3] + columns[1][r] * a[7] + columns[2][r] * a[11]);
    }
    if (!allFinite(b)) return std::nullopt;
    return b;
}

bool allFinite(const Matrix& a) {
    for (const double v : a)
        if (!std::isfinite(v)) return false;
    return true;
}

Quaternion multiply(const Quaternion& a, const Quaternion& b) {
    return {
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

Quaternion conjugate(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }

static double norm(const Quaternion& q) { return std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]); }

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
    // Half the angle between them from the two chords: exact to rounding for small angles, where acos is not.
    const double angle = 2 * std::atan2(norm(difference), norm(sum));
    const double s = std::sin(angle);
    const double from = s < 1e-12 ? 1 - t : std::sin((1 - t) * angle) / s;
    const double to = sign * (s < 1e-12 ? t : std::sin(t * angle) / s);
    Quaternion q;
    for (std::size_t i = 0; i < 4; ++i) q[i] = from * a[i] + to * b[i];
    return normalized(q).value_or(a);
}

Vec3d rotationVector(const Quaternion& q) {
    const double sign = q[3] < 0 ? -1 : 1;  // q and -q are one rotation; w >= 0 is the one of angle <= pi
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

Matrix composeTransform(const std::array<double, 3>& t, const Quaternion& q, const std::array<double, 3>& s) {
    const auto [x, y, z, w] = q;
    return {(1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y - z * w) * s[1],       2 * (x * z + y * w) * s[2],       t[0],
            2 * (x * y + z * w) * s[0],       (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z - x * w) * s[2],       t[1],
            2 * (x * z - y * w) * s[0],       2 * (y * z + x * w) * s[1],       (1 - 2 * (x * x + y * y)) * s[2], t[2]};
}

// Shepperd's method: the largest of w, x, y, z is the one divided by.
static Quaternion rotationOf(const Mat3d& m) {
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

Decomposition decompose(const Matrix& a) {
    Decomposition out;
    out.translation = {a[3], a[7], a[11]};
    Mat3d directions;
    double largest = 0;
    for (int c = 0; c < 3; ++c) {
        const Vec3d column{a[std::size_t(c)], a[std::size_t(c + 4)], a[std::size_t(c + 8)]};
        double s = length(column);
        largest = std::max(largest, s);
        if (c == 0 && determinant(a) < 0) s = -s;
        out.scale[std::size_t(c)] = s;
        for (int r = 0; r < 3; ++r) directions(r, c) = s == 0 ? (r == c) : column[r] / s;
    }
    out.rotation = rotationOf(directions);
    const Matrix again = composeTransform(out.translation, out.rotation, out.scale);
    for (std::size_t i = 0; i < a.size(); ++i)
        if (std::abs(again[i] - a[i]) > 1e-6 * largest) out.exact = false;
    return out;
}

Matrix restTransform(const Node& node) {
    if (!node.matrix) return composeTransform(node.translation, node.rotation, node.scale);
    const std::array<double, 16>& m = *node.matrix;
    return {m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14]};
}

std::vector<Matrix> restGlobals(const std::vector<Node>& nodes) {
    std::vector<Matrix> globals;
    globals.reserve(nodes.size());
    for (const Node& node : nodes) {
        const Matrix local = restTransform(node);
        globals.push_back(node.parent < 0 ? local : multiply(globals[std::size_t(node.parent)], local));
    }
    return globals;
}

}  // namespace penumbra
