#include "formats/common/drawn_mesh.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "formats/common/parallel_for.h"
#include "formats/common/surface_tree.h"

namespace penumbra {

namespace {

// A normal that is the other way costs as much as this distance, in diagonals of the box. A vertex on a hard edge thus
// takes the side that it belongs to, also where the other mesh has the edge a little elsewhere.
constexpr double kNormalDistance = 0.01;
constexpr std::size_t kVerticesOfTask = 256;

struct PointSearch {
    const SurfaceMesh& from;
    const SurfaceMesh& drawn;
    const Sheets* sheets;
    SurfaceTree tree;
    double normal_cost = 0;  // cost of a normal that points the opposite way

    bool sameSheet(std::uint32_t triangle, std::size_t v) const {
        return !sheets || sheets->from[from.mesh.triangles[triangle][0]] == sheets->drawn[v];
    }
    double costOf(std::uint32_t triangle, const std::array<double, 3>& weights, std::size_t v) const {
        constexpr double kNever = std::numeric_limits<double>::infinity();
        if (!sameSheet(triangle, v)) return kNever;
        Vec3d normal;
        for (std::size_t i = 0; i < 3; ++i)
            normal += toDouble(from.normals[from.mesh.triangles[triangle][i]]) * weights[i];
        const double cosine = dot(normalized(normal), toDouble(drawn.normals[v]));
        return cosine > 0 ? normal_cost * (1 - cosine) / 2 : kNever;
    }
};

}  // namespace

PointTable nearestPoints(const SurfaceMesh& from, const SurfaceMesh& drawn, const Sheets* sheets, int threads,
                         PointDistances& distances) {
    assert(from.mesh.two_sided == drawn.mesh.two_sided);
    const std::size_t fronts = drawn.mesh.frontVertexCount();
    const double step = kNormalDistance * boxDiagonal(from.mesh.rest_positions);
    const PointSearch search{from, drawn, sheets, SurfaceTree(from.mesh.frontTriangles(), from.mesh.rest_positions),
                             step * step};
    PointTable points;
    points.corners.resize(drawn.mesh.vertexCount());
    points.weights.resize(drawn.mesh.vertexCount());
    distances.distance.assign(fronts, 0);
    const auto take = [&](std::size_t v) {
        const Vec3 p = drawn.mesh.rest_positions[v];
        auto found = search.tree.nearest(
            p, [&](std::uint32_t t, const std::array<double, 3>& w) { return search.costOf(t, w, v); });
        distances.distance[v] = found ? float(found->distance) : std::numeric_limits<float>::infinity();
        // A vertex whose normal agrees with none takes the nearest point of its sheet, and then any.
        if (!found)
            found = search.tree.nearest(p, [&](std::uint32_t t, const std::array<double, 3>&) {
                return search.sameSheet(t, v) ? 0 : std::numeric_limits<double>::infinity();
            });
        if (!found) found = search.tree.nearest(p, [](std::uint32_t, const std::array<double, 3>&) { return 0.0; });
        points.corners[v] = from.mesh.triangles[found->triangle];
        for (std::size_t i = 0; i < 3; ++i) points.weights[v][i] = float(found->weights[i]);
    };
    parallelFor((fronts + kVerticesOfTask - 1) / kVerticesOfTask, threads, [&](std::size_t task) {
        for (std::size_t v = task * kVerticesOfTask; v < std::min(fronts, (task + 1) * kVerticesOfTask); ++v) take(v);
    });
    const auto back = std::uint32_t(from.mesh.frontVertexCount());
    for (std::size_t v = fronts; v < drawn.mesh.vertexCount(); ++v) {
        const Triangle& corners = points.corners[v - fronts];
        points.corners[v] = {corners[0] + back, corners[1] + back, corners[2] + back};
        points.weights[v] = points.weights[v - fronts];
    }
    return points;
}

PartTable partsOf(const Mesh& mesh, const Skin& skin, const std::optional<DrawnMesh>& drawn) {
    if (!drawn) return makePartTable(mesh, skin);
    PartTable table = makePartTable(drawn->mesh, drawn->skin);
    std::vector<std::uint16_t> part_of_point;
    for (const std::uint32_t v : drawn->vertex_of_point) part_of_point.push_back(table.part_of_vertex[v]);
    table.part_of_vertex = std::move(part_of_point);
    table.part_of_triangle.clear();
    return table;
}

}  // namespace penumbra
