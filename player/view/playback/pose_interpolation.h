#pragma once
// Interpolates poses between the sampled frames of an animation, so that a clip sampled at 3 Hz plays smoothly. No
// truth was baked for such poses.
//
// A joint's motion relative to its parent is L = M_parent^-1 M_joint (skinning matrices, both from the rest pose). It
// moves one point, the pivot, least over the animation: this is where the two are joined. Between frames a and b
//   L(t) x = slerp(R_a, R_b, t) lerp(S_a, S_b, t) (x - pivot) + lerp(L_a pivot, L_b pivot, t),  L = R S (polar)
// so that rigid motions stay rigid, and what is joined there stays joined. Roots move relative to the model's origin.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "sh/quaternion.h"

namespace penumbra {

class PoseInterpolation {
public:
    // `asset` has a mesh, a model and an animation and outlives this object. Allocates all that evaluate() needs.
    explicit PoseInterpolation(const AssetView& asset);

    // Computes the pose `part` of the way from frame `from` to frame `to`, 0..1. At 0 and 1 it is the frame's, bit by
    // bit.
    void evaluate(std::size_t from, std::size_t to, double part);
    std::span<const Affine> bones() const { return bones_; }  // [J]
    std::span<const float> pose() const { return pose_; }     // [P], or empty where the animation's is
    Vec3d pivot(std::size_t joint) const { return joints_[joint].pivot; }
    int parent(std::size_t joint) const { return joints_[joint].parent; }  // -1: its motion is the model's

private:
    struct Transform {
        Mat3d linear;
        Vec3d translation;
    };
    struct Joint {
        int parent = -1;
        Vec3d pivot;
    };
    struct Motion {
        Quaternion rotation;
        Mat3d stretch;
        Vec3d pivot;  // where the joint moves its pivot to
    };
    const AnimationView* animation_;
    std::vector<Joint> joints_;
    std::vector<std::size_t> order_;  // parents stand before their children
    std::size_t from_ = 0, to_ = 0;
    bool has_motions_ = false;  // true if the motions of from_ and to_ are known
    std::vector<Motion> motions_of_from_, motions_of_to_;
    std::vector<Transform> now_;
    std::vector<Affine> bones_;
    std::vector<float> pose_;

    Transform relative(std::size_t frame, std::size_t joint) const;
    Vec3d findPivot(std::size_t joint, Vec3d center) const;
    void findParents();
    void readMotions(std::size_t frame, std::vector<Motion>& motions) const;
    void interpolateBones(double part);
    void interpolateRotationVectors(double part);
};

}  // namespace penumbra
