// What a level ground hides from points above it, against sums over directions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

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
        mirrored.resize(normals.size() * kFarNumbers);
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

// The wedge's edge is cut by the grid of directions, which leaves up to 0.006; the bound is half as wide again.
TEST(GroundShadow, IsTheIntegralOverWhatGoesUp) {
    const Vertices vertices = allWays();
    const std::vector<int> even = evenIndices(kFieldOrder);
    const std::vector<WeightedDirection> directions = gaussHemisphere(192, 512);
    std::vector<float> expected(vertices.mirrored.size());
    for (std::size_t v = 0; v < vertices.normals.size(); ++v) {
        const Vec3 n = vertices.normals[v], t = vertices.tangents[v];
        const Vec3d up{double(t.y), double(cross(n, t).y), double(n.y)};
        std::array<double, coefficientCount(kFieldOrder)> y;
        for (const WeightedDirection& d : directions) {
            if (dot(d.direction, up) <= 0) continue;
            evalBasis(kFieldOrder, d.direction, y);
            for (std::size_t i = 0; i < kFarNumbers; ++i)
                expected[v * kFarNumbers + i] += float(2 * d.weight * y[std::size_t(even[i])]);
        }
    }
    EXPECT_LT(largestDifference(vertices.mirrored, expected), 0.009f);
}

// E of a plane's upper half is (1 + n.y) / 2. In the six bands of V it is 0.003 off at most.
TEST(GroundShadow, LeavesTheShareOfTheSkyThatGoesUp) {
    for (const char* name : {"D5", "A4", "B4"}) {
        const Vertices vertices = allWays();
        const Convention convention = parseConvention(name);
        const std::vector<float> open = freeSight(convention);
        std::vector<float> numbers, e(vertices.normals.size()), expected;
        for (const Vec3 n : vertices.normals) {
            numbers.insert(numbers.end(), open.begin(), open.end());
            expected.push_back((1 + n.y) / 2);
        }
        const CastProduct product(convention);
        product(numbers, open.size(), vertices.mirrored);
        ambient(convention, int(open.size()), numbers, e);
        EXPECT_LT(largestDifference(e, expected), 0.012f) << name;
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
