#include "runtime/sun/sun_frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

constexpr double kTexelSteps = 8;       // steps of the texel's side per octave
constexpr double kMinTexel = 1e-6;      // relative to the coordinates, which are floats
constexpr float kLargestRadius = 1.4f;  // radians; the tangent stays finite

bool isFinite(Vec3d p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

}  // namespace

Mat3d sunAxes(Vec3d toward_sun) {
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(toward_sun[i]) < std::abs(toward_sun[least])) least = i;
    Vec3d axis;
    axis[least] = 1;
    const Vec3d right = normalized(cross(axis, toward_sun));
    return fromRows(right, cross(toward_sun, right), -toward_sun);
}

void includeInBounds(const Mat3d& axes, std::span<const Vec3> points, SunBounds& bounds) {
    for (const Vec3 point : points) {
        const Vec3d p = axes * toDouble(point);
        if (!isFinite(p)) continue;
        for (int i = 0; i < 3; ++i) {
            bounds.low[i] = bounds.empty ? p[i] : std::min(bounds.low[i], p[i]);
            bounds.high[i] = bounds.empty ? p[i] : std::max(bounds.high[i], p[i]);
        }
        bounds.empty = false;
    }
}

double texelStep(double side, const SunBounds& bounds) {
    double largest = 0;
    for (int i = 0; i < 3; ++i) largest = std::max({largest, std::abs(bounds.low[i]), std::abs(bounds.high[i])});
    const double least = std::max({side, kMinTexel * largest, 1e-12});
    return std::exp2(std::ceil(kTexelSteps * std::log2(least)) / kTexelSteps);
}

double fittingTexel(const SunBounds& bounds, int size) {
    const Vec3d extent = bounds.high - bounds.low;
    return texelStep(std::max(extent.x, extent.y) / (size - 3), bounds);
}

SunFrame layFrame(const Mat3d& axes, const SunBounds& bounds, double texel, float radius, int size, Vec3 origin) {
    const Vec3d middle = axes * toDouble(origin);
    SunFrame frame;
    for (int i = 0; i < 3; ++i) {
        const double corner = std::floor(bounds.low[i] / texel) - 1;
        for (int j = 0; j < 3; ++j) frame.rows[std::size_t(i)][std::size_t(j)] = float(axes(i, j));
        frame.rows[std::size_t(i)][3] = float(middle[i] / texel - corner);
    }
    frame.origin = origin;
    frame.range = float((bounds.high.z - middle.z) / texel + double(frame.rows[2][3]) + 1);
    frame.tan_radius = radius > 0 ? std::tan(std::min(radius, kLargestRadius)) : 0.0f;
    frame.texel = float(texel);
    frame.size = size;
    return frame;
}

Vec3 SunFrame::place(Vec3 point) const {
    Vec3 p = turned(point - origin);
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
    SunBounds bounds;
    for (const SunCaster& caster : casters) includeInBounds(axes, caster.positions, bounds);
    if (bounds.empty) return {};
    return layFrame(axes, bounds, fittingTexel(bounds, size), radius, size);
}

}  // namespace penumbra
