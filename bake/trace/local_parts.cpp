#include "bake/trace/local_parts.h"

#include <cassert>

#include "formats/common/part_table.h"

namespace penumbra {

namespace {

PartTable onePart(const Mesh& mesh) {
    PartTable table;
    table.joint_of_part = {0};
    table.part_of_vertex.assign(mesh.vertexCount(), 0);
    table.part_of_triangle.assign(mesh.triangles.size(), 0);
    table.steps = {0};
    return table;
}

}  // namespace

LocalParts makeLocalParts(const Mesh& mesh, const std::optional<Skin>& skin, int steps, std::size_t triangles) {
    assert(triangles >= mesh.frontTriangleCount());
    PartTable table = skin ? makePartTable(mesh, *skin) : onePart(mesh);
    const std::size_t parts = table.partCount();
    LocalParts out{std::move(table.part_of_vertex), std::move(table.part_of_triangle), {}, parts + 1};
    out.part_of_triangle.resize(mesh.frontTriangleCount());  // rays hit the fronts
    out.part_of_triangle.resize(triangles, std::uint16_t(parts));
    out.is_local.assign(parts * (parts + 1), 0);
    for (std::size_t a = 0; a < parts; ++a)
        for (std::size_t b = 0; b < parts; ++b)
            out.is_local[a * (parts + 1) + b] = int(table.stepsBetween(a, b)) <= steps;
    return out;
}

LocalTriangles LocalParts::ofVertex(std::size_t vertex, std::span<const BoundingBox> boxes) const {
    return {part_of_triangle, std::span(is_local).subspan(part_of_vertex[vertex] * row, row), boxes};
}

std::vector<BoundingBox> LocalParts::boxesOf(std::span<const Triangle> triangles,
                                             std::span<const Vec3> positions) const {
    std::vector<std::optional<BoundingBox>> boxes(row);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (const std::uint32_t corner : triangles[t]) {
            std::optional<BoundingBox>& box = boxes[part_of_triangle[t]];
            const BoundingBox point{positions[corner], positions[corner]};
            box = box ? merged(*box, point) : point;
        }
    std::vector<BoundingBox> out;
    for (std::size_t part = 0; part + 1 < row; ++part) out.push_back(boxes[part].value_or(BoundingBox{}));
    return out;
}

}  // namespace penumbra
