#pragma once
// Measures how a triangle mesh is folded: the signed angle at each inner edge (Nowrouzezahrai 2009, section 5.1). Bake,
// fit and run-time evaluator all compute it here, so all have the same numbers. Only innerEdges() allocates.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// The vertices a, b, c, d of an inner edge, with a < b. The triangle that has the edge in the direction a -> b is (a,
// b, c), and the one that has it in the direction b -> a is (b, a, d). Either may start at another of its corners.
using InnerEdge = std::array<std::uint32_t, 4>;

// Returns all inner edges in ascending order of (a, b). An edge is not an inner one when it has one triangle
// (boundary), more than two, or two in the same direction (no common front). Triangles with equal corners are ignored.
// Every corner must be < 2^32 - 1.
std::vector<InnerEdge> innerEdges(std::span<const std::array<std::uint32_t, 3>> triangles);

// Computes the angle between the normals of each edge's two triangles, in radians in (-pi, pi]. It is 0 where they are
// flat, positive where the front of the surface is convex (a ridge) and negative in a valley. It is also 0 where a
// triangle has no area. angles.size() == edges.size().
void dihedralAngles(std::span<const InnerEdge> edges, std::span<const Vec3> positions, std::span<float> angles);

// Returns the number of whole turns that brings `angle` to within half a turn of `before`.
int turnsTowards(float before, float angle);
// Returns angle + turns * 2 pi, with the same bits everywhere.
float addTurns(float angle, int turns);

}  // namespace penumbra
