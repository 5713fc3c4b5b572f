#pragma once
// The first step of an evaluation: what models see of a pose.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

class PoseFeatures {
public:
    // `asset` must outlive this object.
    explicit PoseFeatures(const AssetView& asset);

    // `bones` has J skinning matrices; `pose` has P numbers, or is empty when the model reads bones only. Allocates
    // nothing.
    void set(std::span<const Affine> bones, std::span<const float> pose);
    std::span<const Affine> bones() const { return bones_; }                          // [J]
    const Mat3& rotation(int joint) const { return rotations_[std::size_t(joint)]; }  // nearestRotation() of its bone
    // Returns what the clusters of a joint see: the pose, or all other joints as seen from this one. It is valid until
    // another joint is asked for.
    std::span<const float> of(int joint);

private:
    const AssetView* asset_;
    std::vector<Affine> bones_;
    std::vector<Mat3> rotations_;  // [J]
    std::vector<float> seen_;      // [P] the pose, or [12 (J - 1)] as seen from joint_
    std::vector<bool> absolute_;   // [J] true for joints that stand for a number
    int joint_ = -1;

    bool seesBones() const { return asset_->model.features == FeatureKind::kRelativeBones; }
    void lookFrom(std::size_t joint);
};

}  // namespace penumbra
