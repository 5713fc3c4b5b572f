#pragma once
// The field of a part that is a ball, from the closed form of a blocked cap.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "sh/far/far_visibility.h"
#include "sh/zonal.h"

namespace penumbra {

// V - 1 of a ball of this radius about the origin, seen from `point` outside or inside of it.
inline std::array<float, kFieldCoefficients> ballBlocks(double radius, Vec3d point) {
    const double d = length(point);
    std::array<double, kFieldOrder> zonal;
    capVisibilityZonal(d > radius ? std::asin(radius / d) : std::numbers::pi / 2, zonal);
    std::array<double, kFieldCoefficients> out;
    rotateZonal(zonal, d > 0 ? point / -d : Vec3d{0, 0, 1}, out);
    std::array<float, kFieldCoefficients> result;
    std::copy(out.begin(), out.end(), result.begin());
    result[0] -= float(std::sqrt(4 * std::numbers::pi));
    return result;
}

struct BallField {
    PartField part;
    std::vector<std::int8_t> values, distances;
    FieldTable table() const { return makeFieldTable(part, {values, distances}, 0.02f); }
};

// A ball of radius 1 about `center`, with boxes as penumbra-bake makes them.
inline BallField ballField(Vec3 center = {}) {
    BallField ball;
    ball.part.center = center;
    ball.part.radius = 1;
    for (std::size_t b = 0; b < 2; ++b) {
        const float half = b == 0 ? 1.25f : 2.5f;
        ball.part.boxes[b] = {center - Vec3{half, half, half}, center + Vec3{half, half, half}, {12, 12, 12}};
    }
    // 1. The numbers as they are stored, and what a byte stands for.
    const std::vector<Vec3> points = fieldPoints(ball.part);
    const std::size_t fine = ball.part.boxes[0].pointCount(), coarse = ball.part.boxes[1].pointCount();
    std::vector<std::array<float, kFieldCoefficients>> coefficients;
    for (std::size_t p = 0; p < points.size(); ++p) {
        const std::size_t level = p < fine ? 0 : p < fine + coarse ? 1 : 2;
        const Vec3d offset = toDouble(points[p] - center);
        // A point inside has what its nearest surface point has.
        const double d = length(offset), outside = std::max(d, 1.0);
        coefficients.push_back(ballBlocks(1, d > 0 ? offset * (outside / d) : Vec3d{0, 0, 1}));
        for (std::size_t i = 0; i < kFieldCoefficients; ++i) {
            coefficients[p][i] *= float(d * d + 0.25);
            float& scale = ball.part.scale[level][std::size_t(bandOfIndex(int(i)))];
            scale = std::max(scale, std::abs(coefficients[p][i]) / 127);
        }
    }
    ball.part.distance_scale = 1.0f / 127;
    // 2. The bytes.
    for (std::size_t p = 0; p < points.size(); ++p) {
        const std::size_t level = p < fine ? 0 : p < fine + coarse ? 1 : 2;
        for (std::size_t i = 0; i < kFieldCoefficients; ++i) {
            const float scale = ball.part.scale[level][std::size_t(bandOfIndex(int(i)))];
            ball.values.push_back(std::int8_t(std::lround(scale > 0 ? coefficients[p][i] / scale : 0)));
        }
        const double distance = length(toDouble(points[p] - center)) - 1;
        if (p < fine) ball.distances.push_back(std::int8_t(std::lround(127 * std::clamp(distance, -1.0, 1.0))));
    }
    return ball;
}

}  // namespace penumbra
