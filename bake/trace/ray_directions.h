#pragma once
// The fixed set of directions that every vertex of every frame shares, laid out for packets of eight rays.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int kLanes = 8;  // rays in a packet

// Eight directions, one in each lane. The lanes after the last direction of the set hold zero vectors.
struct alignas(32) DirectionPacket {
    std::array<float, kLanes> x{}, y{}, z{};  // unit vectors
};
// One weight for each lane: 1 where a ray is to be traced (later: where it escaped), 0 elsewhere.
struct alignas(32) LaneWeights {
    std::array<float, kLanes> lane{};
};

struct RayDirections {
    int order = 0;                         // order of the basis that `basis` tabulates
    int count = 0;                         // directions over the whole sphere, 2 N
    std::vector<DirectionPacket> packets;  // ceil(count / kLanes); neighbours along a Morton curve share a packet
    std::vector<float> basis;              // [packet][n^2][kLanes]: 4 pi / count * y_i(direction)
};

// Makes 2 `rays` directions: the spherical Fibonacci set (sh/quadrature.h), sorted along a Morton curve. Seed 1
// leaves the set as it is. Any other seed turns it by a rotation that it draws uniformly.
RayDirections makeRayDirections(int rays, std::uint64_t seed, int order);

// Whether points stand on an infinite floor, which hides all directions with y < 0.
enum class Floor { kNone, kSolid };
// Sets 1 in the lanes with direction . normal > 0 and on a floor direction.y >= 0, and 0 in the others. Returns
// how many lanes hold 1. above.size() == directions.packets.size().
std::size_t aboveHorizon(const RayDirections& directions, Vec3 normal, Floor floor, std::span<LaneWeights> above);

// Computes b_i = sum over the lanes of visible * basis_i. b.size() == coefficientCount(directions.order). The sums
// run in a fixed order, first in float over the packets of each lane, then in double over the lanes, so that every
// run gives the same bits.
void accumulateMoments(const RayDirections& directions, std::span<const LaneWeights> visible, std::span<float> b);

}  // namespace penumbra
