#pragma once
// How a triangle mesh is folded: the signed angle at each inner edge (paper 000, section 5.1). Bake, fit and the
// run-time evaluator compute it here, so that all have the same numbers. No allocation but in innerEdges().
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Vertices a, b, c, d of an inner edge, a < b: the triangle that has the edge in the direction a -> b is (a, b, c), the
// one that has it in the direction b -> a is (b, a, d), each up to the order in which it starts.
using InnerEdge = std::array<std::uint32_t, 4>;

// All inner edges, ascending by (a, b). An edge with one triangle (boundary), more than two, or two in the same
// direction (no common front) is none. Triangles with equal corners count for nothing. Every corner is < 2^32 - 1.
std::vector<InnerEdge> innerEdges(std::span<const std::array<std::uint32_t, 3>> triangles);

// The angle between the normals of the two triangles, radians in (-pi, pi]: 0 where they are flat, positive where the
// front of the surface is convex (a ridge), negative in a valley. 0 where a triangle has no area.
// angles.size() == edges.size().
void dihedralAngles(std::span<const InnerEdge> edges, std::span<const Vec3> positions, std::span<float> angles);

// The number of whole turns that brings `angle` to within half a turn of `before`.
int turnsTowards(float before, float angle);
// angle + turns * 2 pi: the same bits everywhere.
float addTurns(float angle, int turns);

}  // namespace penumbra
