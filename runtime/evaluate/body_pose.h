#pragma once
// The first step of an evaluation: where a pose has the joints and the vertices of a character, and what models see of
// it.
#include <memory>
#include <span>

#include "formats/asset/asset_file.h"
#include "runtime/evaluate/deformation.h"
#include "runtime/evaluate/morphed_rest.h"
#include "runtime/evaluate/pose_features.h"
#include "runtime/evaluate/skinning.h"

namespace penumbra {

struct BodyPose {
    PoseFeatures features;
    MorphedRest rest;                                // rest shape after the weights of morph targets
    std::shared_ptr<const Deformation> deformation;  // null unless the model is deforming; copies share it
    DeformedPose deformed;                           // set for a deforming model

    // `asset` must outlive the pose. The vertices of a deforming mesh are at rest.
    explicit BodyPose(const AssetView& asset);

    // Takes J skinning matrices, and P numbers or none (PoseFeatures). Allocates nothing.
    void set(std::span<const Affine> bones, std::span<const float> pose);
    // Takes the shading points [Vs] and inputs [X] of a deforming mesh, fits the bones, and sets that pose. Allocates
    // nothing.
    void deform(std::span<const Vec3> points, std::span<const float> inputs);

    // Where the vertices of `asset` are. It refers to the pose.
    PosedMesh mesh(const AssetView& asset, const SkinnedVertices& skinned = {}) const {
        return {&asset, &features, rest.positions(), rest.normals(), deformed.points, deformed.normals, skinned};
    }
};

}  // namespace penumbra
