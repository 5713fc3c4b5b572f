#include "bake/reference/reference_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/common/parallel_for.h"

namespace penumbra {

ReferenceScene makeReferenceScene(const ReferenceFrame& input, const ReferenceOptions& options, int threads) {
    const std::vector<RgbBrdf>& brdfs = options.brdfs;
    const std::vector<Vec3>& model = input.frame.positions;
    const BoundingBox box = characterBox(input.mesh.frontTriangles(), model);
    const double diagonal = length(toDouble(box.high) - toDouble(box.low));
    const std::array corners{box.low, box.high};
    const SceneScale scale = input.scale.value_or(sceneScale(corners, diagonal > 0 ? diagonal : 1));
    std::vector<Vec3> positions;
    for (Vec3 p : model) positions.push_back(scale.apply(p));
    // The camera sees surfaces as the player draws them, which has no textures; light passes through them.
    const SeeThrough through =
        input.blockers ? input.blockers->through() : SeeThrough{&input.mesh.opacity, input.twins};
    OcclusionScene scene(positions, input.mesh.frontTriangles(), Queries::kPlain, {nullptr, through.twins});
    std::optional<OcclusionScene> shadows;
    if (!input.mesh.opacity.empty()) shadows.emplace(positions, input.mesh.frontTriangles(), Queries::kPlain, through);
    if (input.blockers) {
        std::vector<Vec3> all(positions.begin(), positions.begin() + std::ptrdiff_t(input.mesh.frontVertexCount()));
        for (Vec3 p : input.occluder_positions) all.push_back(scale.apply(p));
        shadows.emplace(all, input.blockers->triangles, Queries::kFiltered, through);
    }
    if (input.casting_triangles) {
        std::vector<Vec3> all = positions;
        for (const Vec3 p : input.unseen_positions) all.push_back(scale.apply(p));
        const std::span casting = std::span(input.mesh.triangles).first(*input.casting_triangles);
        std::vector<Triangle> triangles(casting.begin(), casting.end());
        triangles.insert(triangles.end(), input.unseen_triangles.begin(), input.unseen_triangles.end());
        shadows.emplace(all, triangles, Queries::kPlain,
                        SeeThrough{nullptr, input.twins.first(std::min(input.twins.size(), casting.size()))});
    }
    std::vector<SampledBrdf> materials(brdfs.size());
    parallelFor(brdfs.size(), threads, [&](std::size_t i) { materials[i] = sampledBrdf(brdfs[i]); });
    std::optional<PointBrdfs> point_brdfs;
    if (!input.pictures.empty()) point_brdfs.emplace(threads);
    return {input,
            scale,
            std::move(positions),
            std::move(scene),
            std::move(shadows),
            std::move(materials),
            options.bias,
            options.bounces,
            options.membranes,
            std::move(point_brdfs)};
}

namespace {

// Returns the frame of the BRDF at a point. Tangents of another cluster than the nearest corner's do not take part.
Mat3d frameAt(const ReferenceFrame& input, const Corners& corners, Vec3d normal) {
    if (!input.tangents) return shadingFrame(normal);
    const PosedTangents& field = *input.tangents;
    Vec3d tangent;
    for (std::size_t k = 0; k < 3; ++k)
        if (field.cluster_of_vertex[corners.vertex[k]] == field.cluster_of_vertex[corners.nearest()])
            tangent += toDouble(field.tangents[corners.vertex[k]]) * corners.weight[k];
    return shadingFrame(normal, tangent);
}

// Returns where the rays of a point of a triangle start. `wanted` is the start where nothing is near.
RayStart startOfShadowRays(const ReferenceScene& scene, const Corners& corners, Vec3d point, Vec3d wanted,
                           double bias) {
    if (!scene.input.blockers) return {toFloat(wanted), false};
    const Blockers& blockers = *scene.input.blockers;
    Triangle own{};
    for (std::size_t k = 0; k < 3; ++k) own[k] = blockers.placeOf(blockers.frontOf(corners.vertex[k]));
    if (std::none_of(own.begin(), own.end(), [&](std::uint32_t p) { return blockers.startsOverSheet(p); }))
        return {toFloat(wanted), false};
    // On a crumpled sheet the interpolated normal may point behind the triangle.
    const Vec3d a = toDouble(scene.positions[own[0]]), b = toDouble(scene.positions[own[1]]),
                c = toDouble(scene.positions[own[2]]);
    const Vec3d flat =
        normalized(cross(b - a, c - a)) * (corners.vertex[0] == blockers.frontOf(corners.vertex[0]) ? 1.0 : -1.0);
    Vec3d way = wanted - point;
    if (!(dot(way, flat) > 0)) way = flat * std::max(length(way), bias);
    return startOverSheet(scene.blocking(), *scene.input.blockers,
                          {toFloat(point), toFloat(normalized(way)), float(length(way)), own,
                           scene.input.blockers->solid_of_vertex[own[0]]});
}

}  // namespace

SurfacePoint surfacePoint(const ReferenceScene& scene, const Corners& corners, Vec3d to_eye) {
    constexpr double kMinSteps = 4;  // distance by which rounding may move a ray, in float steps at the size of the
                                     // triangle's corners
    double bias = scene.bias;
    const Triangle& corner = corners.vertex;
    const std::array<double, 3>& weight = corners.weight;
    Vec3d p[3], n[3], point, normal;
    for (std::size_t k = 0; k < 3; ++k) {
        p[k] = toDouble(scene.positions[corner[k]]);
        for (int axis = 0; axis < 3; ++axis)
            bias = std::max(bias, kMinSteps * double(std::numeric_limits<float>::epsilon()) * std::abs(p[k][axis]));
        n[k] = toDouble(scene.input.frame.normals[corner[k]]);
        point += p[k] * weight[k];
        normal += n[k] * weight[k];
    }
    normal = normalized(normal);
    if (dot(normal, normal) == 0) normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
    Vec3d lifted = point;
    for (std::size_t k = 0; k < 3; ++k) lifted += n[k] * (-weight[k] * std::min(0.0, dot(point - p[k], n[k])));
    const RayStart start = startOfShadowRays(scene, corners, point, lifted + normal * bias, bias);
    const std::span<const std::uint32_t> members = scene.input.member_of_vertex;
    return {start.position, frameAt(scene.input, corners, normal), to_eye, start.closed,
            members.empty() ? 0 : members[corner[0]]};
}

const PictureSurface* picturesAt(const ReferenceFrame& input, const Corners& corners, SurfacePlace& place) {
    for (const PicturePart& part : input.pictures) {
        place = {corners.triangle - part.first_triangle, corners.weight};
        if (corners.triangle < part.first_triangle || place.triangle >= part.surface->triangles()) continue;
        return part.surface->has(place.triangle) ? part.surface : nullptr;
    }
    return nullptr;
}

Corners otherSide(const ReferenceFrame& input, const Corners& corners) {
    Corners other = corners;
    const auto fronts = std::uint32_t(input.mesh.frontVertexCount());
    for (std::uint32_t& corner : other.vertex)
        corner = !input.back_of_vertex.empty() ? input.back_of_vertex[corner]
                 : corner < fronts             ? corner + fronts
                                               : corner - fronts;
    return other;
}

Corners cornersOf(const ReferenceFrame& input, const SurfaceHit& hit, Vec3d ray_direction) {
    const Mesh& mesh = input.mesh;
    Corners corners{mesh.triangles[hit.triangle], {1.0 - double(hit.u) - double(hit.v), hit.u, hit.v}, hit.triangle};
    if (dot(toDouble(hit.normal), ray_direction) <= 0) return corners;
    for (std::uint32_t& corner : corners.vertex) {
        if (mesh.two_sided) corner += std::uint32_t(mesh.frontVertexCount());
        if (!input.back_of_vertex.empty()) corner = input.back_of_vertex[corner];
    }
    return corners;
}

}  // namespace penumbra
