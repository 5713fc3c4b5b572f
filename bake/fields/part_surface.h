#pragma once
// The triangles of one rigid part, and where their surface is nearest to a point.
#include <span>
#include <vector>

#include "formats/common/mesh.h"
#include "sh/far/part_field.h"

namespace penumbra {

// The vertices that a part uses, and its triangles over these.
struct PartMesh {
    std::vector<Vec3> positions;
    std::vector<Triangle> triangles;
    Opacity opacity = {};
    std::vector<std::uint32_t> twins = {};  // twinTriangles() among these; empty: none has one
    bool stands = false;                    // on the ground, in many poses (standingParts())
};
// Takes the triangles [T] for which part_of_triangle is `part` out of a mesh. `twins` are twinTriangles() of the mesh.
PartMesh partMesh(const Mesh& mesh, std::span<const std::uint32_t> twins,
                  std::span<const std::uint16_t> part_of_triangle, std::size_t part);

// A sphere around all points. It is deterministic, and at most a few percent larger than the smallest one.
struct BoundingSphere {
    Vec3d center;
    double radius = 0;
};
BoundingSphere boundingSphere(std::span<const Vec3> points);

// Places the grids of all parts of a character: for each a fine box 0.12 radii around its own, a coarse one 0.9 radii
// around it that holds the smallest sphere, and the spheres. Cells of a box are nearly cubes. A box has cells^3 points
// on average, with more in large parts than in small ones, and fewer in all where the points would take more than
// `most_bytes`, but never fewer than 4 along a side. The fine box of a part that stands has planes on the faces of the
// part's box, at least a cell around it, and four times the points. Scales and joints stay 0.
std::vector<PartField> placeFields(std::span<const PartMesh> meshes, double cells, std::size_t most_bytes);

struct NearestPoint {
    Vec3d point, normal;  // on the surface; the unit normal of the triangle's front
    double distance = 0;
};
// Finds nearest points exactly. It compares a point with the bounding spheres of all triangles first, which is fast
// enough for some millions of them, and always the same.
class NearestSurface {
public:
    // `triangles` is not empty, and every triangle has an area. Positions are of a size near 1 (see SceneScale).
    NearestSurface(std::span<const Vec3> positions, std::span<const Triangle> triangles);
    NearestPoint nearest(Vec3 point) const;

private:
    std::vector<std::array<Vec3d, 3>> corners_;
    std::vector<float> x_, y_, z_, radius_;  // bounding spheres of the triangles
};

}  // namespace penumbra
