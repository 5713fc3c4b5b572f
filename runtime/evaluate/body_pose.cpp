#include "runtime/evaluate/body_pose.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

BodyPose::BodyPose(const AssetView& asset) : features(asset), rest(asset) {
    if (!asset.model.deforming) return;
    deformation = std::make_shared<const Deformation>(asset);
    deformed = deformation->atRest();
}

void BodyPose::set(std::span<const Affine> bones, std::span<const float> pose) {
    features.set(bones, pose);
    rest.setPose(bones);
}

void BodyPose::deform(std::span<const Vec3> points, std::span<const float> inputs) {
    assert(points.size() == deformed.points.size());
    if (points.data() != deformed.points.data()) std::copy(points.begin(), points.end(), deformed.points.begin());
    deformation->follow(inputs, deformed);
    set(deformed.bones, deformed.pose);
}

}  // namespace penumbra
