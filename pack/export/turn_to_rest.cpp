#include "pack/export/turn_to_rest.h"

namespace penumbra {

Vec3 turnedToRest(const PointMotion& motion, Vec3 v) {
    if (!motion.joints.empty() && !motion.bones.empty())
        return transposed(blendBones(motion.joints, motion.weights, motion.bones).linear()) * v;
    // Rodrigues' formula with the axis a x b of length sin and the angle's cosine: v cos + k x v + k (k . v) / (1 +
    // cos).
    const Vec3 k = cross(motion.normal, motion.rest_normal);
    const float cosine = dot(motion.normal, motion.rest_normal);
    if (cosine < -0.999f) return -v;  // no rotation is the smallest one
    return v * cosine + cross(k, v) + k * (dot(k, v) / (1 + cosine));
}

}  // namespace penumbra
