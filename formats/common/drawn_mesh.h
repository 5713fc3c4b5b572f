#pragma once
// A mesh that is drawn with what was measured at the vertices of another one: a level of detail, or the dense mesh of
// a character that was baked at some of its points.
#include <array>
#include <optional>
#include <vector>

#include "formats/common/mesh.h"
#include "formats/common/part_table.h"

namespace penumbra {

// Where each vertex takes its numbers from: three vertices of the other mesh (some may be the same one) with weights.
struct PointTable {
    std::vector<Triangle> corners;              // [W]
    std::vector<std::array<float, 3>> weights;  // [W], >= 0, each row sums to 1

    bool operator==(const PointTable&) const = default;
};

struct DrawnMesh {
    Mesh mesh;                       // W vertices, in the rest space of the other mesh; its slots are its own
    Skin skin;                       // the joints of the other mesh; [W, K] influences
    std::vector<Vec3> rest_normals;  // [W]
    PointTable points;
    // [V] the vertex of `mesh` that each vertex of the other mesh is; empty where the other one is no choice of these.
    std::vector<std::uint32_t> vertex_of_point = {};
};

// A mesh with its normals at rest.
struct SurfaceMesh {
    const Mesh& mesh;
    const std::vector<Vec3>& normals;
};

// How far the vertices of a drawn mesh lie from the other one.
struct PointDistances {
    std::vector<float> distance;  // [fronts], metres; infinite where no point of the other mesh has a normal within 90
                                  // degrees
};

// Looks up the nearest point of `from` for each vertex of `drawn`. Backs take the backs of what their fronts take, so
// both meshes are two-sided or none is. The normal of the point agrees within 90 degrees where there is such a point,
// and of points about as far the one whose normal agrees best is taken. `sheets`, where they are given, name the
// smooth sheet of each vertex of `from` and of `drawn`: only points of a vertex' own sheet count.
struct Sheets {
    std::vector<std::uint32_t> from, drawn;  // [fronts]
};
PointTable nearestPoints(const SurfaceMesh& from, const SurfaceMesh& drawn, const Sheets* sheets, int threads,
                         PointDistances& distances);

// The parts of a baked mesh. Where it is a choice of points they are the parts of the drawn mesh, which fields and
// local moments know; its triangles then have none.
PartTable partsOf(const Mesh& mesh, const Skin& skin, const std::optional<DrawnMesh>& drawn);

}  // namespace penumbra
