// Chooses the tangents of a mesh at rest.
//
// Problem: neighbouring vertices should have nearly equal local frames, because the numbers in these frames are then
// alike and a cluster needs few components. No tangent field is smooth all over a sphere.
//
// Naive: project one axis on all tangent planes. Where a normal lies along the axis, tangents spin around it.
//
// Here: each cluster has a field of its own. A few candidates are singular at different places, and each cluster takes
// the one that turns least over its own edges. The candidates are listed in tangent_frames.h. Then join_tangents.cpp
// makes the fields agree where clusters meet.

#include "fit/clusters/tangent_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/clusters/join_tangents.h"
#include "fit/numerics/pca.h"
#include "formats/common/parallel_for.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

constexpr double kOpposite = -0.999;  // below this cosine the smallest rotation is not well defined

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// Returns the edges of the mesh that lie inside each cluster, every edge once.
std::vector<std::vector<Edge>> edgesOfClusters(const Mesh& mesh, const VertexClusters& clusters) {
    std::vector<std::vector<Edge>> edges(clusters.vertices.size());
    for (const Triangle& t : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [a, b] = std::minmax(t[i], t[(i + 1) % 3]);
            if (clusters.cluster_of_vertex[a] == clusters.cluster_of_vertex[b])
                edges[clusters.cluster_of_vertex[a]].emplace_back(a, b);
        }
    for (auto& list : edges) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return edges;
}

// Returns v, orthogonal to the unit vector a, after the smallest rotation that takes a to the unit vector b.
Vec3d carry(Vec3d a, Vec3d b, Vec3d v) {
    const double cosine = dot(a, b);
    if (cosine < kOpposite) return v;
    return v - (a + b) * (dot(b, v) / (1 + cosine));
}

// A candidate field of tangents.
struct Field {
    Vec3d axis;  // the axis to project, or the tangent at the pole
    Vec3d pole;  // zero for a projection
};

Vec3 evaluate(const Field& field, Vec3 normal) {
    if (field.pole == Vec3d{}) return tangentOf(normal, toFloat(field.axis));
    return tangentOf(normal, toFloat(carry(field.pole, toDouble(normal), field.axis)));
}

// Returns the candidate fields of a cluster.
std::vector<Field> candidateFields(const Mesh& mesh, const std::vector<Vec3>& normals,
                                   const std::vector<std::uint32_t>& vertices) {
    std::vector<Vec3> points;
    Vec3d sum;
    for (std::uint32_t v : vertices) {
        points.push_back(mesh.rest_positions[v]);
        sum += toDouble(normals[v]);
    }
    const std::array<Vec3d, 3> axes = principalAxes(points);
    std::vector<Field> fields;
    // 1. Projections of the three axes.
    for (Vec3d axis : axes) fields.push_back({axis, {}});
    // 2. Fields around the six ends of the axes, then around the mean normal.
    for (std::size_t k = 0; k < 3; ++k)
        for (double sign : {1.0, -1.0}) fields.push_back({axes[(k + 1) % 3], axes[k] * sign});
    if (const Vec3d mean = normalized(sum); length(mean) > 0)
        fields.push_back({toDouble(tangentOf(toFloat(mean), toFloat(axes[0]))), mean});
    return fields;
}

// Returns how much a field turns over the edges.
double turning(const Field& field, const std::vector<Vec3>& normals, const std::vector<Edge>& edges) {
    double sum = 0;
    for (auto [a, b] : edges) {
        const double angle =
            neighbourAngle(normals[a], evaluate(field, normals[a]), normals[b], evaluate(field, normals[b]));
        sum += std::pow(angle, 4);
    }
    return sum;
}

}  // namespace

double neighbourAngle(Vec3 normal_a, Vec3 tangent_a, Vec3 normal_b, Vec3 tangent_b) {
    const Vec3d t = carry(toDouble(normal_a), toDouble(normal_b), toDouble(tangent_a)), b = toDouble(tangent_b);
    return std::atan2(length(cross(t, b)), dot(t, b));
}

Vec3 carriedTangent(Vec3 normal, const Mat3& rotation, Vec3 rest_tangent) {
    return tangentOf(normal, rotation * rest_tangent);
}

Mat3 localFrame(Vec3 normal, Vec3 tangent) { return transposed(fromRows(tangent, cross(normal, tangent), normal)); }

std::vector<Vec3> restTangents(const Mesh& mesh, const std::vector<Vec3>& rest_normals, const VertexClusters& clusters,
                               int threads) {
    const std::vector<std::vector<Edge>> edges = edgesOfClusters(mesh, clusters);
    std::vector<Vec3> tangents(mesh.vertexCount());
    parallelFor(clusters.vertices.size(), threads, [&](std::size_t c) {
        // The candidate that turns least is taken.
        const std::vector<Field> fields = candidateFields(mesh, rest_normals, clusters.vertices[c]);
        std::vector<double> cost;
        for (const Field& field : fields) cost.push_back(turning(field, rest_normals, edges[c]));
        const Field& best = fields[std::size_t(std::min_element(cost.begin(), cost.end()) - cost.begin())];
        for (std::uint32_t v : clusters.vertices[c]) tangents[v] = evaluate(best, rest_normals[v]);
    });
    joinTangents(mesh.triangles, rest_normals, clusters.cluster_of_vertex, tangents);
    return tangents;
}

}  // namespace penumbra
