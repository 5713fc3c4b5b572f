#include "player/frame/visibility_lobe.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace penumbra {

namespace {

// An even number, so that a ring lies in the tangent plane.
constexpr int kLobeRings = 32;

template <class Radius>
Shape lobeOf(const Convention& convention, std::span<const float> coefficients, const Mat3& local_frame, Vec3 center,
             float scale, const Radius& radius) {
    std::vector<float> full(std::size_t(coefficientCount(convention.order))), basis(full.size());
    fullCoefficients(convention, coefficients, full);
    const Mat3 model_from_local = transposed(local_frame);
    Shape lobe = unitSphere(kLobeRings);
    for (Vec3& p : lobe.positions) {
        const Vec3 direction{p.z, p.x, p.y};  // local: the sphere's pole is the normal
        evalBasis(convention.order, direction, basis);
        const float v = std::inner_product(basis.begin(), basis.end(), full.begin(), 0.0f);
        const bool above = direction.z >= -1e-6f;
        lobe.values.push_back({above ? v : 0, 0, 0});
        p = center + model_from_local * direction * (above ? scale * radius(v) : 0);
    }
    return lobe;
}

template <class Color>
void shade(Shape& lobe, Vec3 eye, const Color& color) {
    std::vector<Vec3> normals(lobe.positions.size());  // not unit: sums of twice the triangles' areas
    for (std::size_t t = 0; t < lobe.triangles.size(); t += 3) {
        const std::uint32_t a = lobe.triangles[t], b = lobe.triangles[t + 1], c = lobe.triangles[t + 2];
        const Vec3 n = cross(lobe.positions[b] - lobe.positions[a], lobe.positions[c] - lobe.positions[a]);
        for (const std::uint32_t i : {a, b, c}) normals[i] += n;
    }
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const float facing = std::abs(dot(normalized(normals[i]), normalized(eye - lobe.positions[i])));
        lobe.values[i] = color(lobe.values[i].x) * (0.15f + 0.85f * facing * facing);
    }
}

}  // namespace

Shape visibilityLobe(const Convention& convention, std::span<const float> coefficients, const Mat3& local_frame,
                     Vec3 center, float scale) {
    return lobeOf(convention, coefficients, local_frame, center, scale, [](float v) { return std::max(v, 0.0f); });
}

Shape signedLobe(const Convention& convention, std::span<const float> coefficients, const Mat3& local_frame,
                 Vec3 center, float scale) {
    return lobeOf(convention, coefficients, local_frame, center, scale, [](float v) { return std::abs(v); });
}

void shadeLobe(Shape& lobe, Vec3 eye) {
    shade(lobe, eye, [](float value) {
        const float v = std::clamp(value, 0.0f, 1.0f);
        return Vec3{0.03f, 0.08f, 0.5f} * (1 - v) + Vec3{1, 0.75f, 0.1f} * v;
    });
}

void shadeSignedLobe(Shape& lobe, Vec3 eye) {
    shade(lobe, eye, [](float value) { return value < 0 ? Vec3{0.8f, 0.06f, 0.04f} : Vec3{0.1f, 0.6f, 0.12f}; });
}

}  // namespace penumbra
