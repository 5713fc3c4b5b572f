#include "runtime/evaluate/deformation.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "sh/vertex_normals.h"

namespace penumbra {

namespace {

using Corners = std::array<std::uint32_t, 3>;

std::vector<Corners> asTriangles(std::span<const std::uint32_t> corners) {
    std::vector<Corners> triangles;
    for (std::size_t i = 0; i < corners.size(); i += 3)
        triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    return triangles;
}

}  // namespace

Affine inputBone(const AssetView& asset, const InputJointView& input, std::span<const float> inputs) {
    const float* x = inputs.data() + input.column;
    if (input.columns == 1) return numberBone(x[0], input.offset, input.scale);
    return pointBone({x[0], x[1], x[2]}, asset.model.joint_centers[std::size_t(input.joint)]);
}

Deformation::Deformation(const AssetView& asset) : asset_(&asset) {
    assert(asset.model.deforming);
    // 1. Gather rest positions and parts in the order of the shading points, which the backs of a sheet share.
    const MeshView& mesh = asset.mesh;
    rest_.resize(mesh.pointCount());
    part_of_point_.resize(mesh.pointCount());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        if (mesh.isBack(v)) continue;
        rest_[mesh.shading_point[v]] = mesh.positions[v];
        part_of_point_[mesh.shading_point[v]] = mesh.skin_joints[v];
    }
    for (std::uint32_t v : mesh.frontTriangles()) triangles_.push_back(mesh.shading_point[v]);
    // 2. Dihedral angles need the edges and the whole mesh's PCA.
    if (asset.model.features != FeatureKind::kDihedrals) return;
    edges_ = innerEdges(asTriangles(triangles_));
    pose_basis_.resize(asset.model.pose_basis.count);
    decode(asset.model.pose_basis, pose_basis_);
}

std::vector<float> Deformation::restInputs() const {
    std::vector<float> inputs(asset_->animation.input_names.size());
    for (const InputJointView& input : asset_->model.input_joints) {
        const Vec3 center = asset_->model.joint_centers[std::size_t(input.joint)];
        for (std::size_t i = 0; i < input.columns; ++i)
            inputs[input.column + i] = input.columns == 3 ? center[int(i)] : input.offset;
    }
    return inputs;
}

DeformedPose Deformation::atRest() const {
    DeformedPose pose;
    pose.points = rest_;
    pose.normals.resize(rest_.size());
    pose.bones.resize(asset_->animation.jointCount());
    if (asset_->model.features == FeatureKind::kDihedrals) pose.pose.resize(asset_->animation.pose_size);
    pose.part_sums.resize(pose.bones.size());
    pose.normal_sums.resize(rest_.size());
    pose.angles.resize(edges_.size());
    vertexNormals(triangles_, pose.points, pose.normal_sums, pose.normals);
    return pose;
}

void Deformation::follow(std::span<const float> inputs, DeformedPose& pose) const {
    assert(pose.points.size() == rest_.size() && inputs.size() == asset_->animation.input_names.size());
    vertexNormals(triangles_, pose.points, pose.normal_sums, pose.normals);
    partMotions(rest_, part_of_point_, pose.points, pose.part_sums, pose.bones);
    for (const InputJointView& input : asset_->model.input_joints)
        pose.bones[std::size_t(input.joint)] = inputBone(*asset_, input, inputs);
    if (!pose.pose.empty()) projectAngles(inputs, pose);
}

// Computes the pose of kDihedrals.
void Deformation::projectAngles(std::span<const float> inputs, DeformedPose& pose) const {
    const std::span<const float> mean = asset_->model.pose_mean;
    const std::span<float> angles = pose.angles, out = pose.pose;
    assert(out.size() >= inputs.size() && pose_basis_.size() == (out.size() - inputs.size()) * angles.size());
    // 1. Angles jump by whole turns. Take the turn that is nearest to the mean of the training frames.
    dihedralAngles(edges_, pose.points, angles);
    for (std::size_t e = 0; e < angles.size(); ++e)
        angles[e] = addTurns(angles[e], turnsTowards(mean[e], angles[e])) - mean[e];
    // 2. Project on the PCA of the whole mesh; the inputs follow as they are.
    const float* row = pose_basis_.data();
    for (std::size_t i = 0; i < out.size() - inputs.size(); ++i, row += angles.size()) {
        double sum = 0;
        for (std::size_t e = 0; e < angles.size(); ++e) sum += double(row[e]) * angles[e];
        out[i] = float(sum);
    }
    std::copy(inputs.begin(), inputs.end(), out.end() - std::ptrdiff_t(inputs.size()));
}

}  // namespace penumbra
