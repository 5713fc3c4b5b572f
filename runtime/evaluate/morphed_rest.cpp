#include "runtime/evaluate/morphed_rest.h"

#include <algorithm>

namespace penumbra {

MorphedRest::MorphedRest(const AssetView& asset)
    : asset_(&asset), weights_(asset.mesh.morphs.rest_weights.begin(), asset.mesh.morphs.rest_weights.end()) {
    if (weights_.empty()) return;
    next_ = weights_;
    positions_.resize(asset.mesh.positions.size());
    normals_.resize(positions_.size());
    shape();
}

void MorphedRest::setPose(std::span<const Affine> bones) {
    if (weights_.empty()) return;
    const std::size_t inputs = asset_->animation.input_names.size(), morphs = weights_.size();
    for (const InputJointView& joint : asset_->model.input_joints)
        if (joint.columns == 1 && joint.column + morphs >= inputs)
            next_[joint.column + morphs - inputs] = joint.offset + bones[std::size_t(joint.joint)].m[3] / joint.scale;
    if (next_ == weights_) return;
    weights_ = next_;
    shape();
}

// Adds the targets in their order, as restShape() of the bake does (formats/common/morph_targets.h).
void MorphedRest::shape() {
    const MeshView& mesh = asset_->mesh;
    std::copy(mesh.positions.begin(), mesh.positions.end(), positions_.begin());
    std::copy(mesh.normals.begin(), mesh.normals.end(), normals_.begin());
    for (std::size_t m = 0; m < weights_.size(); ++m)
        addMorph(mesh.morphs.rowsOf(m), weights_[m], positions_, normals_);
    for (const std::uint32_t v : mesh.morphs.vertices) keepNormal(mesh.normals[v], normals_[v]);
}

}  // namespace penumbra
