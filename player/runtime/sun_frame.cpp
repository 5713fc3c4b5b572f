#include "player/runtime/sun_frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace penumbra {

namespace {

constexpr double kTexelSteps = 8;       // of the texel's side, an octave
constexpr double kLeastTexel = 1e-6;    // relative to the coordinates, which are floats
constexpr float kLargestRadius = 1.4f;  // radians; the tangent stays finite

bool isFinite(Vec3d p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// Rows: columns of the map, rows of the map, away from the sun. They depend on the direction alone, so the grid of the
// texels does not turn with the casters.
Mat3d sunAxes(Vec3d toward_sun) {
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(toward_sun[i]) < std::abs(toward_sun[least])) least = i;
    Vec3d axis;
    axis[least] = 1;
    const Vec3d right = normalized(cross(axis, toward_sun));
    return fromRows(right, cross(toward_sun, right), -toward_sun);
}

struct SunBounds {
    Vec3d low, high;
    bool empty = true;
};

SunBounds boundsAlong(const Mat3d& axes, std::span<const SunCaster> casters) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    SunBounds bounds{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
    for (const SunCaster& caster : casters)
        for (const Vec3 position : caster.positions) {
            const Vec3d p = axes * toDouble(position);
            if (!isFinite(p)) continue;
            bounds.empty = false;
            for (int i = 0; i < 3; ++i) {
                bounds.low[i] = std::min(bounds.low[i], p[i]);
                bounds.high[i] = std::max(bounds.high[i], p[i]);
            }
        }
    return bounds;
}

// The least step of the texel's side that fits the bounds with a texel to spare on each side.
double texelFor(const SunBounds& bounds, int size) {
    const Vec3d extent = bounds.high - bounds.low;
    double largest = 0;
    for (int i = 0; i < 3; ++i) largest = std::max({largest, std::abs(bounds.low[i]), std::abs(bounds.high[i])});
    const double fitting = std::max(extent.x, extent.y) / (size - 3);
    const double side = std::max({fitting, kLeastTexel * largest, 1e-12});
    return std::exp2(std::ceil(kTexelSteps * std::log2(side)) / kTexelSteps);
}

}  // namespace

Vec3 SunFrame::place(Vec3 point) const {
    Vec3 p = turned(point);
    for (int i = 0; i < 3; ++i) p[i] = p[i] / texel + rows[std::size_t(i)][3];
    return p;
}

Vec3 SunFrame::turned(Vec3 direction) const {
    Vec3 out;
    for (int i = 0; i < 3; ++i) {
        const std::array<float, 4>& row = rows[std::size_t(i)];
        out[i] = row[0] * direction.x + row[1] * direction.y + row[2] * direction.z;
    }
    return out;
}

SunFrame fitSunFrame(std::span<const SunCaster> casters, Vec3 direction, float radius, int size) {
    assert(size >= kSmallestSunMap && size <= kLargestSunMap);
    const Vec3d toward_sun = normalized(toDouble(direction));
    if (!isFinite(toward_sun) || toward_sun == Vec3d{}) return {};
    const Mat3d axes = sunAxes(toward_sun);
    const SunBounds bounds = boundsAlong(axes, casters);
    if (bounds.empty) return {};

    const double texel = texelFor(bounds, size);
    SunFrame frame;
    for (int i = 0; i < 3; ++i) {
        const double corner = std::floor(bounds.low[i] / texel) - 1;
        for (int j = 0; j < 3; ++j) frame.rows[std::size_t(i)][std::size_t(j)] = float(axes(i, j));
        frame.rows[std::size_t(i)][3] = float(-corner);
    }
    frame.range = float(bounds.high.z / texel + double(frame.rows[2][3]) + 1);
    frame.tan_radius = radius > 0 ? std::tan(std::min(radius, kLargestRadius)) : 0.0f;
    frame.texel = float(texel);
    frame.size = size;
    return frame;
}

}  // namespace penumbra
