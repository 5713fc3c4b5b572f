#include "formats/common/mesh.h"

#include <cassert>

#include "sh/character_box.h"
#include "sh/vertex_normals.h"

namespace penumbra {

double boxDiagonal(const std::vector<Vec3>& positions) {
    const BoundingBox box = boundsOf(positions);
    return length(toDouble(box.high) - toDouble(box.low));
}

BoundingBox characterBox(std::span<const Triangle> triangles, std::span<const Vec3> positions) {
    static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));
    const std::uint32_t* corners = triangles.empty() ? nullptr : triangles.data()->data();
    return characterBox(std::span(corners, 3 * triangles.size()), positions);
}

double characterDiagonal(std::span<const Triangle> triangles, std::span<const Vec3> positions) {
    const BoundingBox box = characterBox(triangles, positions);
    return length(toDouble(box.high) - toDouble(box.low));
}

double characterDiagonal(const Mesh& mesh) { return characterDiagonal(mesh.frontTriangles(), mesh.rest_positions); }

Affine blendBones(std::span<const std::uint16_t> joints, std::span<const float> weights,
                  std::span<const Affine> bones) {
    Affine blend{{}};
    for (std::size_t k = 0; k < joints.size(); ++k) {
        if (weights[k] == 0) continue;
        for (std::size_t i = 0; i < 12; ++i) blend.m[i] += weights[k] * bones[joints[k]].m[i];
    }
    return blend;
}

static void skinRest(std::span<const Vec3> rest_positions, std::span<const Vec3> rest_normals, const Skin& skin,
                     const std::vector<Affine>& bones, RestShape& out) {
    std::vector<Vec3>&positions = out.positions, &normals = out.normals;
    const std::size_t vertices = rest_positions.size(), influences = std::size_t(skin.influences);
    assert(rest_normals.size() == vertices && bones.size() == skin.jointCount());
    assert(skin.joints.size() == vertices * influences && skin.weights.size() == skin.joints.size());
    positions.resize(vertices);
    normals.resize(vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
        const Affine blend = blendBones(std::span(skin.joints).subspan(v * influences, influences),
                                        std::span(skin.weights).subspan(v * influences, influences), bones);
        positions[v] = blend.point(rest_positions[v]);
        normals[v] = normalized(normalMatrix(blend.linear()) * rest_normals[v]);
    }
}

void skinVertices(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& rest_normals,
                  const std::vector<Affine>& bones, std::vector<Vec3>& positions, std::vector<Vec3>& normals) {
    assert(mesh.morphs.empty());
    RestShape out{std::move(positions), std::move(normals)};
    skinRest(mesh.rest_positions, rest_normals, skin, bones, out);
    positions = std::move(out.positions);
    normals = std::move(out.normals);
}

void skinMorphed(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& rest_normals, const SkinPose& pose,
                 RestShape& out) {
    if (mesh.morphs.empty()) return skinRest(mesh.rest_positions, rest_normals, skin, pose.bones, out);
    const RestShape rest = restShape(mesh.morphs, {mesh.rest_positions, rest_normals}, pose.morph_weights);
    skinRest(rest.positions, rest.normals, skin, pose.bones, out);
}

std::vector<Vec3> vertexNormals(std::span<const Triangle> triangles, std::span<const Vec3> positions) {
    std::vector<Vec3d> scratch(positions.size());
    std::vector<Vec3> normals(positions.size());
    static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));
    const std::uint32_t* corners = triangles.empty() ? nullptr : triangles.data()->data();
    vertexNormals(std::span(corners, 3 * triangles.size()), positions, scratch, normals);
    return normals;
}

std::vector<Vec3> meshNormals(const Mesh& mesh, std::span<const Vec3> positions) {
    assert(positions.size() == mesh.vertexCount());
    std::vector<Vec3> normals = vertexNormals(mesh.frontTriangles(), positions.first(mesh.frontVertexCount()));
    if (mesh.two_sided) appendBackNormals(normals);
    return normals;
}

namespace {

template <class T>
void appendCopy(std::vector<T>& items) {
    const std::size_t fronts = items.size();
    items.reserve(2 * fronts);
    for (std::size_t i = 0; i < fronts; ++i) items.push_back(items[i]);
}

}  // namespace

void appendBackPositions(std::vector<Vec3>& positions) { appendCopy(positions); }

void appendBackNormals(std::vector<Vec3>& normals) {
    const std::size_t fronts = normals.size();
    appendCopy(normals);
    for (std::size_t v = fronts; v < normals.size(); ++v) normals[v] = -normals[v];
}

Mesh withBacks(const Mesh& mesh) {
    assert(!mesh.two_sided);
    Mesh out = mesh;
    out.two_sided = true;
    const auto fronts = std::uint32_t(mesh.vertexCount());
    for (const Triangle& t : mesh.triangles) out.triangles.push_back({t[0] + fronts, t[2] + fronts, t[1] + fronts});
    appendBackPositions(out.rest_positions);
    appendCopy(out.slot_of_vertex);
    out.morphs = withBacks(mesh.morphs, fronts);
    return out;
}

Skin withBacks(const Skin& skin) {
    Skin out = skin;
    appendCopy(out.joints);
    appendCopy(out.weights);
    return out;
}

std::vector<Vec3> jointCenters(const Mesh& mesh, const Skin& skin) {
    std::vector<Vec3d> sum(skin.jointCount());
    std::vector<double> weight(skin.jointCount());
    Vec3d all;
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
        all += toDouble(mesh.rest_positions[v]);
        for (std::size_t i = v * std::size_t(skin.influences); i < (v + 1) * std::size_t(skin.influences); ++i) {
            sum[skin.joints[i]] += toDouble(mesh.rest_positions[v]) * double(skin.weights[i]);
            weight[skin.joints[i]] += skin.weights[i];
        }
    }
    std::vector<Vec3> centers;
    for (std::size_t j = 0; j < sum.size(); ++j) {
        std::int32_t source = std::int32_t(j);
        while (source >= 0 && weight[std::size_t(source)] <= 0) source = skin.parents[std::size_t(source)];
        centers.push_back(toFloat(source >= 0 ? sum[std::size_t(source)] / weight[std::size_t(source)]
                                              : all / double(mesh.vertexCount())));
    }
    return centers;
}

}  // namespace penumbra
