#pragma once
// Decides which triangles a ray passes through.
#include <bit>
#include <cstdint>
#include <span>

#include "formats/common/opacity.h"
#include "sh/vec3.h"

namespace penumbra {

struct SeeThrough {
    const Opacity* opacity = nullptr;  // null: every triangle stops every ray
    // [T] twinTriangles() of the scene, or empty. Of two twins the first alone is in the scene.
    std::span<const std::uint32_t> twins = {};
};

// A number of 24 bits that looks random, by the bits of a ray and by a triangle. The same ray meets the same triangle
// with the same answer, whatever thread, packet or order of the search asks. Each word goes through a step of
// MurmurHash3 (Appleby 2011), and its finisher ends it.
inline std::uint32_t rayNumber(Vec3 origin, Vec3 direction, std::uint32_t triangle) {
    std::uint32_t h = triangle * 0x9e3779b9u;
    for (const float value : {origin.x, origin.y, origin.z, direction.x, direction.y, direction.z}) {
        h ^= std::rotl(std::bit_cast<std::uint32_t>(value) * 0xcc9e2d51u, 15) * 0x1b873593u;
        h = std::rotl(h, 13) * 5 + 0xe6546b64u;
    }
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return (h ^ (h >> 16)) >> 8;
}

// Tells whether a triangle stops a ray at a piece with this value.
inline bool stopsRay(std::uint8_t value, Vec3 origin, Vec3 direction, std::uint32_t triangle) {
    return value == kStopsAll ||
           (value > 0 && rayNumber(origin, direction, triangle) * 255ull < (std::uint64_t(value) << 24));
}

}  // namespace penumbra
