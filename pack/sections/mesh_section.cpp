#include "pack/sections/mesh_section.h"

#include <algorithm>
#include <span>

#include "formats/common/errors.h"
#include "sh/tangent.h"
#include "sh/turn_about_normal.h"

namespace penumbra {

namespace {

// Returns the vertices in the order of the clusters: order[new] = old.
std::vector<std::uint32_t> clusterOrder(const Model& model) {
    std::vector<std::uint32_t> order;
    for (const ClusterModel& cluster : model.clusters)
        order.insert(order.end(), cluster.vertices.begin(), cluster.vertices.end());
    return order;
}

// A mesh with what a section has of each vertex.
struct SectionSource {
    const Mesh& mesh;
    const Skin& skin;
    const std::vector<Vec3>&normals, &tangents;
    const Skin* skin_of_twins;  // null for a deforming mesh
};

MeshSection sectionOf(const SectionSource& source, const std::vector<std::uint32_t>& order) {
    const std::size_t influences = std::size_t(source.skin.influences);
    MeshSection mesh;
    mesh.influences = source.skin.influences;
    mesh.two_sided = source.mesh.two_sided;
    mesh.shading_point = order;
    mesh.slots = source.mesh.slots;
    std::vector<std::uint32_t> new_of_old(order.size());
    for (std::size_t v = 0; v < order.size(); ++v) {
        const std::uint32_t old = order[v];
        new_of_old[old] = std::uint32_t(v);
        mesh.positions.push_back(source.mesh.rest_positions[old]);
        mesh.normals.push_back(source.normals[old]);
        mesh.tangents.push_back(source.tangents[old]);
        if (!mesh.slots.empty()) mesh.slot_of_vertex.push_back(source.mesh.slot_of_vertex[old]);
        const auto joints = source.skin.joints.begin() + std::ptrdiff_t(old * influences);
        const auto weights = source.skin.weights.begin() + std::ptrdiff_t(old * influences);
        mesh.skin_joints.insert(mesh.skin_joints.end(), joints, joints + std::ptrdiff_t(influences));
        mesh.skin_weights.insert(mesh.skin_weights.end(), weights, weights + std::ptrdiff_t(influences));
    }
    mesh.morphs = selectVertices(source.mesh.morphs, order);
    for (const Triangle& t : source.mesh.triangles)
        mesh.triangles.push_back({new_of_old[t[0]], new_of_old[t[1]], new_of_old[t[2]]});
    for (std::uint32_t old : source.mesh.source_vertex) mesh.source_vertex.push_back(new_of_old[old]);
    addSurface(source.mesh, source.skin_of_twins, new_of_old, mesh);
    return mesh;
}

std::size_t leadOf(const std::array<float, 3>& w) { return w[0] >= w[1] && w[0] >= w[2] ? 0 : w[1] >= w[2] ? 1 : 2; }

}  // namespace

MeshSection meshSection(const Model& model) {
    return sectionOf(
        {model.mesh, model.skin, model.rest_normals, model.rest_tangents, model.deforming ? nullptr : &model.skin},
        clusterOrder(model));
}

MeshSection denseSection(const Model& model) {
    if (model.deforming) throw Unsupported("a mesh without a skeleton has no chosen points");
    const DrawnMesh& drawn = *model.drawn;
    const std::size_t dense = drawn.mesh.vertexCount(), count = model.mesh.vertexCount();
    std::vector<std::uint32_t> order, place(count);  // order of the points in the section
    std::vector<bool> taken(dense);
    for (const std::uint32_t point : clusterOrder(model)) {
        place[point] = std::uint32_t(order.size());
        order.push_back(drawn.vertex_of_point[point]);
        taken[order.back()] = true;
    }
    std::vector<Vec3> tangents(dense);
    for (std::size_t p = 0; p < count; ++p) tangents[drawn.vertex_of_point[p]] = model.rest_tangents[p];
    std::vector<Triangle> corners;
    std::vector<std::array<float, 3>> weights;
    for (std::uint32_t v = 0; v < dense; ++v) {
        if (taken[v]) continue;
        order.push_back(v);
        const Triangle& c = drawn.points.corners[v];
        corners.push_back({place[c[0]], place[c[1]], place[c[2]]});
        weights.push_back(drawn.points.weights[v]);
        const std::uint32_t lead = c[leadOf(weights.back())];
        const Vec3 normal = drawn.rest_normals[v];
        tangents[v] = tangentOf(normal, carriedTangent(model.rest_normals[lead], normal, model.rest_tangents[lead]));
    }
    MeshSection section = sectionOf({drawn.mesh, drawn.skin, drawn.rest_normals, tangents, &drawn.skin}, order);
    section.point_corners = std::move(corners);
    section.point_weights = std::move(weights);
    return section;
}

VertexParts partsOf(const Model& model, const MeshSection& section) {
    if (!model.composition) return {};
    const Composition& composition = *model.composition;
    const std::vector<std::uint16_t>& parts = composition.part_of_vertex;
    const std::size_t columns = composition.near_count;
    if (parts.size() != model.mesh.vertexCount())
        throw InvalidInput("model.composition.part_of_vertex: must have one part for each vertex");
    if (composition.near_gains.size() != parts.size() * columns)
        throw InvalidInput("model.composition.near_gains: must have near_count gains for each vertex");
    VertexParts out;
    for (const std::uint32_t old : clusterOrder(model)) {
        out.part_of_vertex.push_back(parts[old]);
        const auto gains = composition.near_gains.begin() + std::ptrdiff_t(old * columns);
        out.near_gains.insert(out.near_gains.end(), gains, gains + std::ptrdiff_t(columns));
    }
    for (std::size_t q = 0; q < section.point_corners.size(); ++q)
        out.part_of_vertex.push_back(out.part_of_vertex[section.point_corners[q][leadOf(section.point_weights[q])]]);
    return out;
}

}  // namespace penumbra
