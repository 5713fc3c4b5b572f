#include <gtest/gtest.h>

#include "fit/clusters/tangent_frames.h"
#include "tests/difference.h"
#include "tests/fit/synthetic_character.h"

namespace penumbra::test_tangent_frames {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

VertexClusters oneCluster(std::size_t vertices) {
    VertexClusters clusters;
    clusters.cluster_of_vertex.assign(vertices, 0);
    clusters.vertices.resize(1);
    for (std::size_t v = 0; v < vertices; ++v) clusters.vertices[0].push_back(std::uint32_t(v));
    clusters.joint = {0};
    return clusters;
}

double largestAngle(const Mesh& mesh, const std::vector<Vec3>& normals, const std::vector<Vec3>& tangents) {
    Largest largest;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i)
            largest.add(
                neighbourAngle(normals[t[i]], tangents[t[i]], normals[t[(i + 1) % 3]], tangents[t[(i + 1) % 3]]));
    return largest;
}

void expectUnitAndOrthogonal(const std::vector<Vec3>& normals, const std::vector<Vec3>& tangents) {
    for (std::size_t v = 0; v < normals.size(); ++v) {
        EXPECT_NEAR(length(tangents[v]), 1, 1e-5) << v;
        EXPECT_NEAR(dot(tangents[v], normals[v]), 0, 1e-5) << v;
    }
}

// Around a straight tube the projected axis is parallel, so carried tangents agree exactly.
TEST(TangentFrames, AreParallelOnATube) {
    const Mesh mesh = synthetic::tube(30, 12);
    std::vector<Vec3> normals;
    for (Vec3 p : mesh.rest_positions) normals.push_back(normalized(Vec3{p.x, 0, p.z}));
    const std::vector<Vec3> tangents = restTangents(mesh, normals, oneCluster(normals.size()), 1);
    expectUnitAndOrthogonal(normals, tangents);
    EXPECT_LT(largestAngle(mesh, normals, tangents), 1e-3);
}

// Makes a cap of the unit sphere with half-angle `angle`, in rings from the pole.
Mesh cap(double angle, std::size_t rings, std::size_t sides) {
    Mesh mesh;
    mesh.rest_positions.push_back({0, 1, 0});
    for (std::size_t r = 1; r <= rings; ++r)
        for (std::size_t s = 0; s < sides; ++s) {
            const double theta = angle * double(r) / double(rings);
            const double phi = 2 * std::numbers::pi * double(s) / double(sides);
            mesh.rest_positions.push_back({float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                                           float(std::sin(theta) * std::sin(phi))});
        }
    const auto at = [&](std::size_t ring, std::size_t side) {
        return std::uint32_t(ring == 0 ? 0 : 1 + (ring - 1) * sides + side % sides);
    };
    for (std::size_t r = 0; r < rings; ++r)
        for (std::size_t s = 0; s < sides; ++s) {
            if (r > 0) mesh.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s)});
            mesh.triangles.push_back({at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)});
        }
    return mesh;
}

// On three quarters of a sphere any projected direction is singular somewhere (neighbours differ by up to 180 degrees).
// The field carried from the pole turns most along the rim, theta = 120 degrees. There an edge of 10 degrees of azimuth
// turns by about 10 (1 - cos theta) = 15 degrees; measured 15.1.
TEST(TangentFrames, AreSmoothOnASphereThatNoProjectionCovers) {
    const Mesh mesh = cap(120 * kDegree, 12, 36);
    const std::vector<Vec3>& normals = mesh.rest_positions;
    const std::vector<Vec3> tangents = restTangents(mesh, normals, oneCluster(normals.size()), 1);
    expectUnitAndOrthogonal(normals, tangents);
    EXPECT_LT(largestAngle(mesh, normals, tangents), 18 * kDegree);
}

TEST(TangentFrames, OfASmallPatchHardlyTurn) {
    const Mesh mesh = cap(0.5, 8, 24);
    const std::vector<Vec3> tangents = restTangents(mesh, mesh.rest_positions, oneCluster(mesh.vertexCount()), 1);
    EXPECT_LT(largestAngle(mesh, mesh.rest_positions, tangents), 2.5 * kDegree);
}

// Puts each vertex into the cluster that cluster_of(place) names; all clusters have vertices.
VertexClusters clustersBy(const Mesh& mesh, std::size_t count, auto cluster_of) {
    VertexClusters clusters;
    clusters.vertices.resize(count);
    clusters.joint.assign(count, 0);
    for (std::uint32_t v = 0; v < mesh.vertexCount(); ++v) {
        clusters.cluster_of_vertex.push_back(std::uint32_t(cluster_of(mesh.rest_positions[v])));
        clusters.vertices[clusters.cluster_of_vertex[v]].push_back(v);
    }
    return clusters;
}

// A flat sheet of 24 x 24 cells, in clusters that are long in x or in z by turns: their principal axes are 90 degrees
// apart. A sheet has a parallel field, and turning whole clusters finds it.
TEST(TangentFrames, OfAFlatSheetAreParallelAcrossClusters) {
    Mesh mesh;
    for (int z = 0; z <= 24; ++z)
        for (int x = 0; x <= 24; ++x) mesh.rest_positions.push_back({float(x), 0, float(z)});
    for (std::uint32_t z = 0; z < 24; ++z)
        for (std::uint32_t x = 0; x < 24; ++x) {
            const std::uint32_t a = z * 25 + x;
            mesh.triangles.push_back({a, a + 25, a + 1});
            mesh.triangles.push_back({a + 1, a + 25, a + 26});
        }
    const std::vector<Vec3> normals(mesh.vertexCount(), {0, 1, 0});
    const VertexClusters clusters = clustersBy(mesh, 5, [](Vec3 p) {
        return p.x < 6 ? 0 : p.x > 18 ? 1 : p.z < 6 ? 2 : p.z > 18 ? 3 : 4;
    });
    const std::vector<Vec3> tangents = restTangents(mesh, normals, clusters, 1);
    expectUnitAndOrthogonal(normals, tangents);
    EXPECT_LT(largestAngle(mesh, normals, tangents), 0.01 * kDegree);
}

// A hemisphere in nine clusters, whose own fields differ by up to 147 degrees where they meet. Turning whole clusters
// leaves 66 degrees, because the surface is curved, and blending must do the rest; measured 8.8.
TEST(TangentFrames, OfAHemisphereJumpNowhereBetweenClusters) {
    const Mesh mesh = cap(90 * kDegree, 24, 72);
    const std::vector<Vec3>& normals = mesh.rest_positions;
    const VertexClusters clusters = clustersBy(mesh, 9, [](Vec3 p) {
        const int around = int((std::atan2(double(p.z), double(p.x)) + std::numbers::pi) / (0.5 * std::numbers::pi));
        return p.y > 0.9f ? 8 : std::min(around, 3) + (p.y > 0.5f ? 0 : 4);
    });
    const std::vector<Vec3> tangents = restTangents(mesh, normals, clusters, 1);
    expectUnitAndOrthogonal(normals, tangents);
    EXPECT_LT(largestAngle(mesh, normals, tangents), 12 * kDegree);
}

TEST(TangentFrames, FollowARigidMotion) {
    const Mat3 r = synthetic::rotationAbout({1, 2, -1}, 2.1f);
    const Vec3 n{0, 0, 1}, t{1, 0, 0};
    const Vec3 carried = carriedTangent(r * n, r, t);
    EXPECT_NEAR(length(carried - r * t), 0, 1e-6);
    const Mat3 frame = localFrame(r * n, carried);
    EXPECT_NEAR(length(frame * Vec3{0, 0, 1} - r * n), 0, 1e-6);
    EXPECT_NEAR(length(frame * Vec3{1, 0, 0} - r * t), 0, 1e-6);
}

TEST(TangentFrames, HaveAUnitTangentEvenWhereTheProjectionVanishes) {
    const Vec3 t = carriedTangent({0, 0, 1}, Mat3{}, {0, 0, 1});
    EXPECT_NEAR(length(t), 1, 1e-6);
    EXPECT_NEAR(t.z, 0, 1e-6);
}

}  // namespace
}  // namespace penumbra::test_tangent_frames
