#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "sh/far/far_tables.h"
#include "sh/far/floor_factor.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_basis.h"
#include "sh/visibility_convention.h"

namespace penumbra::test_floor_factor {
namespace {

struct Frames {
    std::vector<Vec3> normals, tangents;
};

Frames someFrames() {
    Frames frames;
    for (int i = 0; i < 60; ++i) {
        const float a = 0.71f * float(i), tilt = 3.1415f * float(i) / 59, turn = 0.37f * float(i);
        const Vec3 n{std::sin(tilt) * std::cos(a), std::cos(tilt), std::sin(tilt) * std::sin(a)};
        const Vec3 t{std::cos(tilt) * std::cos(a), -std::sin(tilt), std::cos(tilt) * std::sin(a)};
        frames.normals.push_back(n);
        frames.tangents.push_back(t * std::cos(turn) + cross(n, t) * std::sin(turn));
    }
    return frames;
}

std::vector<float> floorAt(const Frames& frames) {
    std::vector<float> out(frames.normals.size() * kFarCoefficients);
    floorVisibility(frames.normals, frames.tangents, out);
    return out;
}

// 2 integral of V y over the hemisphere, by directions that are dense enough for a step.
TEST(FloorFactor, IsTheMirroredHalfSpace) {
    const Frames frames = someFrames();
    const std::vector<float> rows = floorAt(frames);
    const std::vector<int> even = evenIndices(kFieldOrder);
    std::vector<double> y(kFieldCoefficients);
    for (std::size_t r = 0; r < frames.normals.size(); r += 7) {
        const Vec3d n = toDouble(frames.normals[r]), t = toDouble(frames.tangents[r]), b = cross(n, t);
        std::array<double, kFarCoefficients> expected{};
        for (const WeightedDirection& d : gaussHemisphere(300, 600)) {
            if ((t * d.direction.x + b * d.direction.y + n * d.direction.z).y < 0) continue;
            evalBasis(kFieldOrder, d.direction, std::span<double>(y));
            for (std::size_t e = 0; e < kFarCoefficients; ++e) expected[e] += 2 * d.weight * y[std::size_t(even[e])];
        }
        for (std::size_t e = 0; e < kFarCoefficients; ++e)
            EXPECT_NEAR(rows[r * kFarCoefficients + e], expected[e], 0.02) << r << " " << e;
    }
}

// E past a floor is (1 + cos tilt) / 2.
TEST(FloorFactor, HasTheFormFactorOfThePlane) {
    const Frames frames = someFrames();
    const std::vector<float> rows = floorAt(frames);
    std::array<float, kFarCoefficients> weights;
    ambientWeights(parseConvention("D6"), weights);
    for (std::size_t r = 0; r < frames.normals.size(); ++r) {
        double e = 0;
        for (std::size_t i = 0; i < kFarCoefficients; ++i) e += double(weights[i] * rows[r * kFarCoefficients + i]);
        EXPECT_NEAR(e, (1 + double(frames.normals[r].y)) / 2, 0.01) << r;  // six bands of a step
    }
}

TEST(FloorFactor, MultipliesFarVisibilities) {
    const Frames frames = someFrames();
    const std::vector<float> expected = floorAt(frames);
    std::vector<float> far(expected.size());
    for (std::size_t r = 0; r < frames.normals.size(); ++r) far[r * kFarCoefficients] = 3.5449077f;
    multiplyByFloor(fastestFarPath(), frames.normals, frames.tangents, far);
    for (std::size_t i = 0; i < far.size(); ++i) EXPECT_NEAR(far[i], expected[i], 2e-5);
}

}  // namespace
}  // namespace penumbra::test_floor_factor
