#pragma once
// The rest pose of an asset with morph targets, as the weights of the pose shape it (formats/asset.fbs, Morphs). Bones
// then move it as they move any other rest pose.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

class MorphedRest {
public:
    // `asset` has a model and outlives this object. The weights are those at rest.
    explicit MorphedRest(const AssetView& asset);

    // Takes the weights from the bones of the joints that stand for them, [J]. Does nothing where there are no targets,
    // and little where the weights stay as they are. Allocates nothing.
    void setPose(std::span<const Affine> bones);

    std::span<const float> weights() const { return weights_; }  // [M]
    // Without targets these are the asset's own.
    std::span<const Vec3> positions() const { return positions_.empty() ? asset_->mesh.positions : positions_; }  // [V]
    std::span<const Vec3> normals() const { return normals_.empty() ? asset_->mesh.normals : normals_; }

private:
    const AssetView* asset_;
    std::vector<float> weights_, next_;
    std::vector<Vec3> positions_, normals_;  // empty without targets

    void shape();
};

}  // namespace penumbra
