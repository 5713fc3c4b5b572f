#include "runtime/evaluate/skinning.h"

#include <algorithm>
#include <cassert>

#include "sh/lanes.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

// Blends the bones that move a vertex, by its weights (linear blend skinning).
Affine blendBones(const MeshView& mesh, std::size_t vertex, std::span<const Affine> bones) {
    Quad rows[3] = {};
    const std::size_t first = vertex * std::size_t(mesh.influences);
    for (std::size_t k = first; k < first + std::size_t(mesh.influences); ++k) {
        const float weight = mesh.skin_weights[k];
        if (weight == 0) continue;
        const float* bone = bones[mesh.skin_joints[k]].m.data();
        for (int row = 0; row < 3; ++row) rows[row] += weight * loadQuad(bone + 4 * row);
    }
    Affine blend;
    __builtin_memcpy(blend.m.data(), rows, sizeof rows);
    return blend;
}

}  // namespace

std::size_t clusterAt(const AssetView& asset, std::size_t vertex) {
    const std::vector<ClusterView>& clusters = asset.model.clusters;
    const auto after = std::upper_bound(clusters.begin(), clusters.end(), asset.mesh.leaderOf(vertex),
                                        [](std::size_t v, const ClusterView& c) { return v < c.first_vertex; });
    return std::size_t(after - clusters.begin()) - 1;
}

Receiver PosedMesh::vertex(std::size_t vertex, std::size_t cluster) const {
    if (!skinned.positions.empty())
        return {skinned.positions[vertex], skinned.normals[vertex], skinned.tangents[vertex]};
    const MeshView& mesh = asset->mesh;
    Receiver out;
    if (asset->model.deforming) {
        const std::size_t point = mesh.pointOf(vertex);
        out.position = points[point];
        out.normal = mesh.isBack(vertex) ? -point_normals[point] : point_normals[point];
    } else {
        const Affine blend = blendBones(mesh, vertex, pose->bones());
        out.position = blend.point(rest_positions[vertex]);
        out.normal = normalized(normalMatrix(blend.linear()) * rest_normals[vertex]);
    }
    const Mat3& turn = pose->rotation(asset->model.clusters[cluster].joint);
    out.tangent = tangentOf(out.normal, mesh.tangents.empty() ? Vec3{} : turn * mesh.tangents[vertex]);
    return out;
}

void PosedMesh::skin(std::size_t begin, std::span<Vec3> positions, std::span<Vec3> normals,
                     std::span<Vec3> tangents) const {
    assert(begin + positions.size() <= asset->mesh.positions.size());
    if (positions.empty()) return;  // `begin` may be behind the last vertex, which has no cluster
    const std::vector<ClusterView>& clusters = asset->model.clusters;
    const std::size_t first_follower = asset->mesh.firstFollower();
    // Clusters are contiguous ranges of vertices: find the one that has `begin`, then go along.
    std::size_t cluster = clusterAt(*asset, begin);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const std::size_t v = begin + i;
        if (v >= first_follower)
            cluster = clusterAt(*asset, v);
        else if (v >= clusters[cluster].first_vertex + std::size_t(clusters[cluster].vertex_count))
            ++cluster;
        const Receiver one = vertex(v, cluster);
        positions[i] = one.position;
        normals[i] = one.normal;
        tangents[i] = one.tangent;
    }
}

}  // namespace penumbra
