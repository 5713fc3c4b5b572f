// The checks of two-sided sheets, of inputs, and of meshes whose vertices are given instead of skinned.
#include <array>
#include <cmath>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/asset/asset_field.h"
#include "sh/dihedral_angles.h"

namespace penumbra {

namespace {

void checkFronts(const Field& at, const MeshView& mesh, std::span<const std::uint32_t> vertices) {
    for (std::size_t i = 0; i < vertices.size(); ++i)
        if (mesh.isBack(vertices[i])) at[i].fail("is the back of a vertex");
}

}  // namespace

// Checks the pairing of fronts and backs. The run time and the viewers rely on it: they compute fronts and turn them
// round.
void setTwoSided(const fbs::Mesh& stored, const Field& at, MeshView& mesh) {
    mesh.cull_backs = stored.cull_backs() || stored.two_sided();
    if (!stored.two_sided()) return;
    const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size() / 3;
    (at / "two_sided").require(vertices % 2 == 0, "is set, but the number of vertices is odd");
    (at / "two_sided").require(triangles % 2 == 0, "is set, but the number of triangles is odd");
    mesh.two_sided = true;
    const std::size_t points = mesh.pointCount();
    std::vector<std::uint32_t> vertex_of_point(vertices);
    for (std::size_t v = 0; v < vertices; ++v) vertex_of_point[mesh.shading_point[v]] = std::uint32_t(v);
    for (std::size_t s = 0; s < points; ++s) {
        const std::size_t front = vertex_of_point[s], back = vertex_of_point[points + s];
        if (mesh.positions[front] != mesh.positions[back])
            (at / "positions")[back].fail("is the back of a vertex that is elsewhere");
        if (mesh.normals[front] != -mesh.normals[back])
            (at / "normals")[back].fail("is not the negated normal of its front");
    }
    checkFronts(at / "triangles", mesh, mesh.frontTriangles());
    for (std::size_t t = 0; t < triangles / 2; ++t)
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::size_t front = mesh.triangles[3 * t + (3 - corner) % 3];
            const std::size_t i = 3 * (triangles / 2 + t) + corner;
            if (mesh.triangles[i] != vertex_of_point[points + mesh.shading_point[front]])
                (at / "triangles")[i].fail("is not that of triangle " + std::to_string(t) + " from behind");
        }
    checkFronts(at / "source_vertex", mesh, mesh.source_vertex);
}

void setInputs(const fbs::Animation& stored, const Field& at, AnimationView& animation) {
    if (stored.input_names())
        for (const flatbuffers::String* name : *stored.input_names()) animation.input_names.push_back(textOf(name));
    checkUniqueNames(at / "input_names", animation.input_names);
    animation.inputs =
        floatsOf(stored.inputs(), at / "inputs", std::uint64_t(animation.frameCount()) * animation.input_names.size());
}

void setPlayback(const fbs::Animation& stored, const Field& at, const AssetView& asset, PlaybackView& playback) {
    playback.positions = spanOf<std::uint16_t>(stored.positions(), at / "positions");
    if (playback.positions.empty()) return;
    (at / "positions").require(asset.has_mesh, "are given without a mesh");
    (at / "positions")
        .require(asset.model.deforming || (!asset.has_model && asset.mesh.influences == 0),
                 "are given, but the mesh is skinned");
    checkCount(at / "positions", playback.positions,
               3 * std::uint64_t(asset.animation.frameCount()) * asset.mesh.pointCount());
    if (!stored.positions_origin() || stored.positions_origin()->size() != 3)
        (at / "positions_origin").fail("must have 3 elements");
    const auto bounded = [](float number) { return std::abs(number) <= 1e30f; };  // false for NaN
    for (int i = 0; i < 3; ++i) {
        playback.origin[i] = stored.positions_origin()->Get(flatbuffers::uoffset_t(i));
        (at / "positions_origin").require(bounded(playback.origin[i]), "is not finite, or above 1e30");
    }
    playback.step = stored.positions_step();
    playback.error = stored.positions_error();
    (at / "positions_step").require(bounded(playback.step) && playback.step >= 0, "is not a number of 0..1e30");
    (at / "positions_error").require(bounded(playback.error) && playback.error >= 0, "is not a number of 0..1e30");
}

namespace {

InputJointView inputJointOf(const fbs::InputJoint& stored, const Field& at, std::int64_t joint,
                            const AnimationView& animation) {
    InputJointView input;
    input.joint = stored.joint();
    checkRange(at / "joint", input.joint, joint, joint);
    input.columns = stored.columns();
    (at / "columns").require(input.columns == 1 || input.columns == 3, "must be 1 or 3");
    input.column = stored.column();
    checkRange(at / "column", stored.column(), 0,
               std::int64_t(animation.input_names.size()) - std::int64_t(input.columns));
    input.offset = stored.offset();
    input.scale = stored.scale();
    (at / "offset").require(std::isfinite(input.offset), "is not finite");
    (at / "scale").require(std::isfinite(input.scale), "is not finite");
    return input;
}

std::size_t innerEdgeCount(const MeshView& mesh) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const std::span<const std::uint32_t> corners = mesh.frontTriangles();
    for (std::size_t i = 0; i < corners.size(); i += 3)
        triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    return innerEdges(triangles).size();
}

void setDihedralPose(const fbs::Model& stored, const Field& at, const AssetView& asset, ModelView& model) {
    model.pose_mean = spanOf<float>(stored.pose_mean(), at / "pose_mean");
    checkFinite(at / "pose_mean", model.pose_mean);
    if (model.features != FeatureKind::kDihedrals) {
        checkCount(at / "pose_mean", model.pose_mean, 0);
        (at / "pose_basis").require(!stored.pose_basis(), "is given, but the features are not dihedral angles");
        return;
    }
    at.require(model.deforming, "reads dihedral angles, but is not deforming");
    checkCount(at / "pose_mean", model.pose_mean, innerEdgeCount(asset.mesh));
    const AnimationView& animation = asset.animation;
    // There are no more principal components than angles. Otherwise a small file could ask for a great many numbers
    // of the pose.
    const std::size_t inputs = animation.input_names.size();
    (at / "pose_mean")
        .require(animation.pose_size >= inputs && animation.pose_size - inputs <= model.pose_mean.size(),
                 "and animation.input_names do not fit animation.pose_size");
    model.pose_basis = numbersOf(stored.pose_basis(), at / "pose_basis", animation.pose_size - inputs,
                                 model.pose_mean.size(), AssetPrecision::kF16);
}

// Checks that each vertex has one rigid part: whole weights, and none on a joint that stands for inputs.
void checkParts(const Field& at, const MeshView& mesh, std::size_t parts) {
    checkRange(at / "mesh.influences", mesh.influences, 1, 1);
    checkIndices(at / "mesh.skin_joints", mesh.skin_joints, parts);
}

}  // namespace

void setDeforming(const fbs::Model& stored, const Field& file, const AssetView& asset, ModelView& model) {
    const Field at = file / "model";
    model.deforming = stored.deforming();
    const std::size_t count = stored.input_joints() ? stored.input_joints()->size() : 0;
    const std::size_t joints = asset.animation.jointCount();
    checkRange(at / "input_joints", std::int64_t(count), 0, std::int64_t(joints));
    for (std::size_t i = 0; i < count; ++i)
        model.input_joints.push_back(inputJointOf(*stored.input_joints()->Get(flatbuffers::uoffset_t(i)),
                                                  (at / "input_joints")[i], std::int64_t(joints - count + i),
                                                  asset.animation));
    setDihedralPose(stored, at, asset, model);
    if (model.deforming) checkParts(file, asset.mesh, joints - count);
}

}  // namespace penumbra
