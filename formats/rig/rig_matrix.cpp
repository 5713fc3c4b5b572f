#include "formats/rig/rig_matrix.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

Matrix toMatrix(const Affine& a) {
    Matrix m;
    std::copy(a.m.begin(), a.m.end(), m.begin());
    return m;
}

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

namespace {

std::array<Vec3d, 3> linearRows(const Matrix& a) {
    return {Vec3d{a[0], a[1], a[2]}, Vec3d{a[4], a[5], a[6]}, Vec3d{a[8], a[9], a[10]}};
}

}  // namespace

double determinant(const Matrix& a) {
    const auto [r0, r1, r2] = linearRows(a);
    return dot(r0, cross(r1, r2));
}

std::optional<Matrix> inverse(const Matrix& a) {
    const auto [r0, r1, r2] = linearRows(a);
    const double det = determinant(a);
    // |det| is at most the product of the row lengths (Hadamard). Far below that product the rows are dependent.
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

Matrix composeTransform(const std::array<double, 3>& t, const Quaternion& q, const std::array<double, 3>& s) {
    const Mat3d r = matrixOf(q);
    Matrix a;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t c = 0; c < 3; ++c) a[4 * row + c] = r.m[3 * row + c] * s[c];
        a[4 * row + 3] = t[row];
    }
    return a;
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
    out.rotation = quaternionOf(directions);
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
