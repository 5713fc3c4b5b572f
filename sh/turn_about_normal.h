#pragma once
// Brings numbers of one vertex to the local frame of another.
//
// Numbers that stand for a function of a local frame follow the normal: they stay what they are relative to it, and
// are turned about it by the angle between the two tangents. That is exact within a band.
#include <cstddef>
#include <span>
#include <vector>

#include "sh/vec3.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// The SH band and order of each number of a vertex: number i turns with number partner[i] by the angle order[i] times
// that of the frame.
struct TurnTable {
    std::vector<int> order;            // m; 0: it does not turn
    std::vector<std::size_t> partner;  // the number of -m in the same band

    std::size_t size() const { return order.size(); }
};
TurnTable turnsOf(const Convention& convention);
TurnTable turnsOfIndirect();  // of sh/indirect_coefficients.h

// Turns functions of a local frame: its x axis stands at an angle (radians, about the normal) in the new frame.
struct FrameTurn {
    const TurnTable& turns;
    std::vector<float> cosine, sine;  // of m times the angle
};
FrameTurn makeTurn(const TurnTable& turns, double angle);
// `in` and `out` have turns.size() numbers and do not overlap.
void apply(const FrameTurn& turn, std::span<const float> in, std::span<float> out);
// Adds `weight` times the turned numbers to `out` without an allocation. `cosine` and `sine` are of the angle.
void addTurned(const TurnTable& turns, float cosine, float sine, float weight, std::span<const float> in,
               std::span<float> out);

// Returns the angle of the tangent `a` in a frame with the tangent `b`; both lie in the plane of the unit `normal`.
double angleBetween(Vec3 normal, Vec3 a, Vec3 b);
// Returns `tangent`, orthogonal to the unit vector a, after the smallest rotation that takes a to the unit vector b.
Vec3 carriedTangent(Vec3 a, Vec3 b, Vec3 tangent);

}  // namespace penumbra
