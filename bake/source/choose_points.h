#pragma once
// Chooses the points of a dense character that are baked. All other vertices interpolate between them.
#include <cstdint>
#include <vector>

#include "formats/stage/visibility_file.h"

namespace penumbra {

struct ChosenPoints {
    std::vector<std::uint32_t> vertices;  // ascending
    std::vector<Triangle> triangles;      // triangles between chosen vertices, as indices into `vertices`
};

// Collapses edges of the mesh onto one of their ends until `count` vertices are left, or no edge can collapse. What is
// lost least comes first: the squared distance from the planes of the triangles that a vertex stood for (Garland and
// Heckbert 1997), and a share of the squared distance from the vertices themselves, both weighted by area. The first
// keeps points where the surface bends and at edges, the second spreads them over flat parts. Boundaries, which hard
// edges are, only shrink along themselves, and no triangle turns over. Edges of more than two triangles stay. Vertices
// without a triangle are not chosen. The same mesh gives the same points.
ChosenPoints choosePoints(const Mesh& mesh, std::size_t count);

// Returns the triangles of a mesh whose corners go on from slot to slot: of vertices that differ in their slot alone
// they have the first. Points that are chosen of these interpolate on both sides of a border of slots, so that both
// sides see the same.
std::vector<Triangle> trianglesAcrossSlots(const DrawnMesh& drawn);

// Makes mesh, skin and rest normals of `header` those of the points, of header.drawn, and fills in its tables: each
// vertex interpolates in the nearest triangle of points of its own connected sheet.
void takePoints(ChosenPoints chosen, VisibilityHeader& header);

}  // namespace penumbra
