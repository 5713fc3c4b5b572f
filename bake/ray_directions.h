#pragma once
// The fixed set of directions that every vertex of every frame shares, laid out for packets of eight rays.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int kLanes = 8;  // rays in a packet

struct alignas(32) DirectionPacket {
    std::array<float, kLanes> x{}, y{}, z{};  // unit; lanes beyond the set are zero vectors
};
// 1 where a ray is traced, or escaped; 0 where it is not.
struct alignas(32) LaneWeights {
    std::array<float, kLanes> lane{};
};

struct RayDirections {
    int order = 0;                         // of the basis table
    int count = 0;                         // directions over the whole sphere, 2 N
    std::vector<DirectionPacket> packets;  // ceil(count / kLanes), neighbours along a Morton curve
    std::vector<float> basis;              // [packet][n^2][kLanes]: 4 pi / count * y_i(direction)
};

// 2 `rays` directions: the spherical Fibonacci set (sh/quadrature.h) as it is for seed 1, turned by a rotation that any
// other seed draws uniformly; sorted along a Morton curve.
RayDirections makeRayDirections(int rays, std::uint64_t seed, int order);

// 1 in the lanes with direction . normal > 0 and, with `ground`, direction.y >= 0; returns how many there are.
// above.size() == packets.size().
std::size_t aboveHorizon(const RayDirections& directions, Vec3 normal, bool ground, std::span<LaneWeights> above);

// b_i = sum over the lanes of visible * basis_i. b.size() == coefficientCount(directions.order). Sums run in a fixed
// order: per lane in float over the packets, then over the lanes in double.
void accumulateMoments(const RayDirections& directions, std::span<const LaneWeights> visible, std::span<float> b);

}  // namespace penumbra
