#pragma once
// Small fixed-size linear algebra. Matrices are row-major; vectors are columns: y = M x.
#include <array>
#include <cmath>

namespace penumbra {

template <class T>
struct BasicVec3 {
    T x{}, y{}, z{};

    constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr T operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    friend constexpr BasicVec3 operator+(BasicVec3 a, BasicVec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend constexpr BasicVec3 operator-(BasicVec3 a, BasicVec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr BasicVec3 operator-(BasicVec3 a) { return {-a.x, -a.y, -a.z}; }
    friend constexpr BasicVec3 operator*(BasicVec3 a, T s) { return {a.x * s, a.y * s, a.z * s}; }
    friend constexpr BasicVec3 operator*(T s, BasicVec3 a) { return a * s; }
    friend constexpr BasicVec3 operator*(BasicVec3 a, BasicVec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
    friend constexpr BasicVec3 operator/(BasicVec3 a, T s) { return {a.x / s, a.y / s, a.z / s}; }
    constexpr BasicVec3& operator+=(BasicVec3 b) { return *this = *this + b; }
    constexpr BasicVec3& operator-=(BasicVec3 b) { return *this = *this - b; }
    constexpr BasicVec3& operator*=(T s) { return *this = *this * s; }
    constexpr bool operator==(const BasicVec3&) const = default;
};
using Vec3 = BasicVec3<float>;
using Vec3d = BasicVec3<double>;

template <class T>
constexpr T dot(BasicVec3<T> a, BasicVec3<T> b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr BasicVec3<T> cross(BasicVec3<T> a, BasicVec3<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(BasicVec3<T> a) {
    return std::sqrt(dot(a, a));
}
// Returns a / |a|; a zero vector stays zero.
template <class T>
BasicVec3<T> normalized(BasicVec3<T> a) {
    const T l = length(a);
    return l > T(0) ? a / l : BasicVec3<T>{};
}
constexpr Vec3d toDouble(Vec3 a) { return {a.x, a.y, a.z}; }
constexpr Vec3 toFloat(Vec3d a) { return {float(a.x), float(a.y), float(a.z)}; }

template <class T>
struct BasicMat3 {
    std::array<T, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major

    constexpr T& operator()(int row, int column) { return m[3 * row + column]; }
    constexpr T operator()(int row, int column) const { return m[3 * row + column]; }
    friend constexpr BasicVec3<T> operator*(const BasicMat3& a, BasicVec3<T> v) {
        return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z, a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
                a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
    }
    friend constexpr BasicMat3 operator*(const BasicMat3& a, const BasicMat3& b) {
        BasicMat3 c;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
        return c;
    }
    constexpr bool operator==(const BasicMat3&) const = default;
};
using Mat3 = BasicMat3<float>;
using Mat3d = BasicMat3<double>;
constexpr Mat3d toDouble(const Mat3& a) {
    Mat3d out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = a.m[i];
    return out;
}

template <class T>
constexpr BasicMat3<T> transposed(const BasicMat3<T>& a) {
    return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}
template <class T>
constexpr BasicMat3<T> fromRows(BasicVec3<T> a, BasicVec3<T> b, BasicVec3<T> c) {
    return {{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z}};
}
// Returns the cofactor matrix, det(A) A^-T. Normals transform with it when points transform with A. It is defined for a
// singular A too.
template <class T>
constexpr BasicMat3<T> cofactor(const BasicMat3<T>& a) {
    const BasicVec3<T> r0{a.m[0], a.m[1], a.m[2]}, r1{a.m[3], a.m[4], a.m[5]}, r2{a.m[6], a.m[7], a.m[8]};
    return fromRows(cross(r1, r2), cross(r2, r0), cross(r0, r1));
}

template <class T>
constexpr T determinant(const BasicMat3<T>& a) {
    const BasicVec3<T> r0{a.m[0], a.m[1], a.m[2]}, r1{a.m[3], a.m[4], a.m[5]}, r2{a.m[6], a.m[7], a.m[8]};
    return dot(r0, cross(r1, r2));
}
// Returns what turns normals when points transform with A, up to its length: the cofactor matrix with the sign of the
// determinant. Where A mirrors, the outside so stays outside.
template <class T>
constexpr BasicMat3<T> normalMatrix(const BasicMat3<T>& a) {
    BasicMat3<T> c = cofactor(a);
    if (determinant(a) < 0)
        for (T& m : c.m) m = -m;
    return c;
}

// Maps p to linear p + translation. The 12 floats are row-major 3x4, as /frames/bones stores them.
struct Affine {
    std::array<float, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

    constexpr Mat3 linear() const { return {{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}}; }
    constexpr Vec3 translation() const { return {m[3], m[7], m[11]}; }
    constexpr Vec3 point(Vec3 p) const { return linear() * p + translation(); }
    constexpr bool operator==(const Affine&) const = default;
};

// Returns the rotation of the polar decomposition of `a`, which is the nearest rotation in the Frobenius norm;
// reflections are removed. A singular `a` gives some rotation, always the same one for the same input. It computes in
// double and is deterministic.
Mat3 nearestRotation(const Mat3& a);

}  // namespace penumbra
