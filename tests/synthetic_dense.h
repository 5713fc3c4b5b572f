#pragma once
#include "formats/stage/model_file.h"

namespace penumbra::synthetic {

// Makes the vertices of a model the points of a denser mesh, which has a vertex more within each triangle.
inline void addDense(Model& model) {
    DrawnMesh drawn{model.mesh, model.skin, model.rest_normals, {}, {}};
    const auto points = std::uint32_t(model.mesh.vertexCount());
    const auto influences = std::size_t(model.skin.influences);
    for (std::uint32_t v = 0; v < points; ++v) {
        drawn.points.corners.push_back({v, v, v});
        drawn.points.weights.push_back({1, 0, 0});
        drawn.vertex_of_point.push_back(v);
    }
    drawn.mesh.triangles.clear();
    for (const auto& [a, b, c] : model.mesh.triangles) {
        const auto w = std::uint32_t(drawn.mesh.vertexCount());
        const std::vector<Vec3>&p = model.mesh.rest_positions, &n = model.rest_normals;
        drawn.mesh.rest_positions.push_back(p[a] * 0.5f + p[b] * 0.3f + p[c] * 0.2f);
        drawn.rest_normals.push_back(normalized(n[a] * 0.5f + n[b] * 0.3f + n[c] * 0.2f));
        for (std::size_t k = a * influences; k < (a + 1) * influences; ++k) {
            drawn.skin.joints.push_back(model.skin.joints[k]);
            drawn.skin.weights.push_back(model.skin.weights[k]);
        }
        if (!model.mesh.slots.empty()) drawn.mesh.slot_of_vertex.push_back(model.mesh.slot_of_vertex[a]);
        drawn.points.corners.push_back({a, b, c});
        drawn.points.weights.push_back({0.5f, 0.3f, 0.2f});
        for (const Triangle& t : {Triangle{a, b, w}, {b, c, w}, {c, a, w}}) drawn.mesh.triangles.push_back(t);
    }
    model.drawn = std::move(drawn);
}

}  // namespace penumbra::synthetic
