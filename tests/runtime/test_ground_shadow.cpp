// What a level ground hides from points above it, against sums over directions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "runtime/cast/cast_product.h"
#include "runtime/cast/ground_shadow.h"
#include "runtime/shade/shading.h"
#include "sh/far/far_tables.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/tangent.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"

namespace penumbra::test_ground_shadow {
namespace {

struct Vertices {
    std::vector<Vec3> normals, tangents;
    std::vector<float> mirrored;

    // `tilt` and `azimuth` of the normal, and how far the tangent is turned about it.
    void add(float tilt, float azimuth, float turn) {
        const Vec3 n{std::sin(tilt) * std::cos(azimuth), std::cos(tilt), std::sin(tilt) * std::sin(azimuth)};
        const Vec3 t = tangentOf(n, {1, 0, 0});
        normals.push_back(n);
        tangents.push_back(t * std::cos(turn) + cross(n, t) * std::sin(turn));
    }
    void evaluate() {
        mirrored.resize(normals.size() * kFarCoefficients);
        groundVisibility(normals, tangents, mirrored);
    }
};

Vertices allWays() {
    Vertices out;
    for (const float tilt : {0.0f, 0.3f, 1.2f, 1.5707963f, 2.0f, 2.9f, 3.14159265f})
        for (const float azimuth : {0.4f, 2.5f})
            for (const float turn : {0.0f, 1.0f, -2.0f}) out.add(tilt, azimuth, turn);
    out.evaluate();
    return out;
}

// V y over the wedge between the horizon and the plane of the ground, by nodes about its edge. Measured: 2e-6.
TEST(GroundShadow, IsTheIntegralOverWhatGoesUp) {
    const Vertices vertices = allWays();
    const std::vector<int> even = evenIndices(kFieldOrder);
    std::vector<float> expected(vertices.mirrored.size());
    for (std::size_t v = 0; v < vertices.normals.size(); ++v) {
        const Vec3 n = vertices.normals[v], t = vertices.tangents[v];
        const double x = double(t.y), y = double(cross(n, t).y), across = std::max(std::hypot(x, y), 1e-9);
        const Vec3d to_up{x / across, y / across, 0}, z{0, 0, 1}, edge = cross(z, to_up);
        const double width = std::acos(-double(n.y));
        std::array<double, coefficientCount(kFieldOrder)> basis;
        for (const WeightedNumber& a : gaussInterval(24))
            for (const WeightedNumber& b : gaussInterval(24)) {
                const double e = a.x * std::numbers::pi, w = b.x * width;
                evalBasis(kFieldOrder, (to_up * std::cos(w) + z * std::sin(w)) * std::sin(e) + edge * std::cos(e),
                          basis);
                const double weight = 2 * a.weight * std::numbers::pi * b.weight * width * std::sin(e);
                for (std::size_t i = 0; i < kFarCoefficients; ++i)
                    expected[v * kFarCoefficients + i] += float(weight * basis[std::size_t(even[i])]);
            }
    }
    EXPECT_LT(largestDifference(vertices.mirrored, expected), 1e-5);
}

// E of the upper half of a plane is (1 + n.y) / 2. The bands of the numbers blur it. Measured: 0.0121, in B4.
TEST(GroundShadow, LeavesTheShareOfTheSkyThatGoesUp) {
    for (const char* name : {"D5", "A4", "B4"}) {
        const Vertices vertices = allWays();
        const Convention convention = parseConvention(name);
        const std::vector<float> open = freeSight(convention);
        std::vector<float> coefficients, e(vertices.normals.size()), expected;
        for (const Vec3 n : vertices.normals) {
            coefficients.insert(coefficients.end(), open.begin(), open.end());
            expected.push_back((1 + n.y) / 2);
        }
        const CastProduct product(convention);
        product(coefficients, open.size(), vertices.mirrored);
        ambient(convention, int(open.size()), coefficients, e);
        EXPECT_LT(largestDifference(e, expected), 0.015) << name;
    }
}

TEST(GroundShadow, IsFreeSightForWhatFacesUp) {
    Vertices vertices;
    vertices.add(0, 0, 0.7f);
    vertices.evaluate();
    EXPECT_NEAR(vertices.mirrored[0], 2 * std::sqrt(M_PI), 1e-5);
    EXPECT_LT(std::abs(*std::max_element(vertices.mirrored.begin() + 1, vertices.mirrored.end())), 1e-5f);
}

TEST(GroundShadow, AllocatesNothing) {
    Vertices vertices = allWays();
    const std::size_t before = allocationCount();
    groundVisibility(vertices.normals, vertices.tangents, vertices.mirrored);
    EXPECT_EQ(allocationCount(), before);
}

}  // namespace
}  // namespace penumbra::test_ground_shadow
