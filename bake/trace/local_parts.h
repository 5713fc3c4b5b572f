#pragma once
// Tells which triangles of a bake are local to which vertex, for the local moments (LocalMoments of
// formats/stage/visibility_file.h).
#include <optional>

#include "bake/trace/occlusion.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct LocalParts {
    std::vector<std::uint16_t> part_of_vertex;    // [V], backs included
    std::vector<std::uint16_t> part_of_triangle;  // [T] fronts of the mesh, then occluders, whose part is P
    std::vector<std::uint8_t> is_local;           // [P, P + 1] from the part of a vertex to that of a triangle
    std::size_t row = 0;                          // P + 1

    // `boxes` are those of this frame. Refers to them and to this object.
    LocalTriangles ofVertex(std::size_t vertex, std::span<const BoundingBox> boxes) const;
    // Returns [P] boxes around the triangles of each part. `positions` are those of the front vertices at least.
    std::vector<BoundingBox> boxesOf(std::span<const Triangle> triangles, std::span<const Vec3> positions) const;
};
// `triangles` counts those of the mesh's fronts and of all occluders. Without a skin the mesh is one part.
LocalParts makeLocalParts(const Mesh& mesh, const std::optional<Skin>& skin, int steps, std::size_t triangles);

}  // namespace penumbra
