#pragma once
// Where the depth map of a sun lies: an orthographic view along the sun's rays, fitted to what casts shadows. The CPU's
// map and the one of GL share it.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

constexpr int kMaxSunMaps = 8;                             // suns of a light
constexpr int kSunMapSize = 1024;                          // default, texels a side
constexpr int kSmallestSunMap = 8, kLargestSunMap = 8192;  // texels a side

// A mesh that casts shadows with both sides of its triangles. Triangles with a vertex that is not finite are skipped.
struct SunCaster {
    std::span<const Vec3> positions;           // [V]
    std::span<const std::uint32_t> triangles;  // [3 T]
};

// All who cast on one another.
struct SunCasters {
    std::vector<SunCaster> members;    // characters, props, cloths
    SunCaster ground = {};             // one that casts; without triangles there is none
    std::uint64_t ground_version = 0;  // changes whenever the ground does; 0: it may change at any time
};

// Places of points in the map. All lengths are in texels, along the rays too.
struct SunFrame {
    // A point p has the place (column, row, depth), where place i is rows[i].xyz . (p - origin) / texel + rows[i].w.
    // Texel k covers k to k + 1. The depth counts from the caster that is nearest to the sun, and grows away from the
    // sun.
    std::array<std::array<float, 4>, 3> rows{};
    Vec3 origin{};         // lies near the points of a small map, so that floats tell them apart
    float range = 0;       // depth of the caster that is farthest from the sun; the map stores depth / range
    float tan_radius = 0;  // tangent of the sun's angular radius
    float texel = 0;       // a texel's side in the scene's units
    int size = 0;          // texels a side; 0: nothing casts, and no point is shadowed

    Vec3 place(Vec3 point) const;
    Vec3 turned(Vec3 direction) const;  // a unit vector along columns, rows and depths
};

// Rows: columns of the map, rows of the map, away from the sun. They depend on the direction alone, so the grid of the
// texels does not turn with the casters. `toward_sun` is a unit vector.
Mat3d sunAxes(Vec3d toward_sun);

struct SunBounds {
    Vec3d low, high;
    bool empty = true;
};
// Includes all finite points, along the axes.
void includeInBounds(const Mat3d& axes, std::span<const Vec3> points, SunBounds& bounds);

// The least step of a texel's side that is as large as `side` and that floats at these bounds can tell.
double texelStep(double side, const SunBounds& bounds);
// The least step that fits the bounds into `size` texels with a texel to spare on each side.
double fittingTexel(const SunBounds& bounds, int size);

// Lays a map on the grid of texels. It begins a texel before the low bounds and ends behind the depth of the high ones.
SunFrame layFrame(const Mat3d& axes, const SunBounds& bounds, double texel, float radius, int size, Vec3 origin = {});

// Fits the map of `size` texels a side to the casters. `direction` is a unit vector towards the sun, `radius` the
// sun's angular radius in radians. Receivers need no place in the map: what lies outside of it is lit, and depths
// beyond its range compare as any other. The texel's side grows in steps of 2^(1/8), and the map's corner lies at a
// multiple of it, so that edges stay where they are while casters move by parts of a texel. Gives an empty frame when
// no caster has a finite vertex, or when the direction is not finite or 0.
SunFrame fitSunFrame(std::span<const SunCaster> casters, Vec3 direction, float radius, int size = kSunMapSize);

}  // namespace penumbra
