#pragma once
// Where the depth map of a sun lies: an orthographic view along the sun's rays, fitted to what casts shadows. The CPU's
// map and the one of GL share it.
#include <array>
#include <cstdint>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

constexpr int kMaxSunMaps = 3;                             // suns of a light
constexpr int kSunMapSize = 1024;                          // default, texels a side
constexpr int kSmallestSunMap = 8, kLargestSunMap = 8192;  // texels a side

// A mesh that casts shadows with both sides of its triangles. Triangles with a vertex that is not finite are skipped.
struct SunCaster {
    std::span<const Vec3> positions;           // [V]
    std::span<const std::uint32_t> triangles;  // [3 T]
};

// Places of points in the map. All lengths are in texels, along the rays too.
struct SunFrame {
    // A point p has the place (column, row, depth), where place i is rows[i].xyz . p / texel + rows[i].w. Texel k
    // covers k to k + 1. The depth counts from the caster that is nearest to the sun, and grows away from the sun.
    std::array<std::array<float, 4>, 3> rows{};
    float range = 0;       // depth of the caster that is farthest from the sun; the map stores depth / range
    float tan_radius = 0;  // of the sun
    float texel = 0;       // a texel's side in the scene's units
    int size = 0;          // texels a side; 0: nothing casts, and no point is shadowed

    Vec3 place(Vec3 point) const;
    Vec3 turned(Vec3 direction) const;  // a unit vector along columns, rows and depths
};

// Fits the map of `size` texels a side to the casters. `direction` is a unit vector towards the sun, `radius` the
// sun's angular radius in radians. Receivers need no place in the map: what lies outside of it is lit, and depths
// beyond its range compare as any other. The texel's side grows in steps of 2^(1/8), and the map's corner lies at a
// multiple of it, so that edges stay where they are while casters move by parts of a texel. Gives an empty frame when
// no caster has a finite vertex, or when the direction is not finite or 0.
SunFrame fitSunFrame(std::span<const SunCaster> casters, Vec3 direction, float radius, int size = kSunMapSize);

}  // namespace penumbra
