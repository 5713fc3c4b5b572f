#include "runtime/evaluate/joint_chain.h"

#include <cassert>
#include <cmath>

namespace penumbra {

bool hasRestTransforms(const AnimationView& animation) {
    return !animation.rest_transforms.empty() && animation.rest_transforms.size() == animation.jointCount();
}

namespace {

Affine multiply(const Affine& a, const Affine& b) {
    const Mat3 linear = a.linear() * b.linear();
    const Vec3 at = a.point(b.translation());
    return {{linear(0, 0), linear(0, 1), linear(0, 2), at.x, linear(1, 0), linear(1, 1), linear(1, 2), at.y,
             linear(2, 0), linear(2, 1), linear(2, 2), at.z}};
}

// Rodrigues' formula: exp(r) = I + sin(a)/a [r] + (1 - cos a)/a^2 [r]^2, a = |r|. Small angles use its series.
Affine rotationBy(Vec3 r) {
    const float square = dot(r, r), angle = std::sqrt(square), half = std::sin(angle / 2);
    const float s = angle > 1e-4f ? std::sin(angle) / angle : 1 - square / 6;
    const float t = angle > 1e-4f ? 2 * half * half / square : 0.5f - square / 24;
    const float diagonal = 1 - t * square;
    return {{diagonal + t * r.x * r.x, t * r.x * r.y - s * r.z, t * r.x * r.z + s * r.y, 0,  //
             t * r.x * r.y + s * r.z, diagonal + t * r.y * r.y, t * r.y * r.z - s * r.x, 0,  //
             t * r.x * r.z - s * r.y, t * r.y * r.z + s * r.x, diagonal + t * r.z * r.z, 0}};
}

}  // namespace

JointChain::JointChain(const AnimationView& animation)
    : parents_(animation.parents),
      rest_(animation.rest_transforms),
      inverse_bind_(animation.inverse_bind),
      globals_(animation.jointCount()) {
    // Orders the joints such that parents come first: from each joint go up to one that has a place, then place the
    // path down.
    std::vector<bool> placed(parents_.size());
    std::vector<std::size_t> path;
    for (std::size_t start = 0; start < parents_.size(); ++start) {
        for (std::int64_t j = std::int64_t(start); j >= 0 && !placed[std::size_t(j)]; j = parents_[std::size_t(j)])
            path.push_back(std::size_t(j));  // openAsset() made sure that it ends
        for (; !path.empty(); path.pop_back()) {
            placed[path.back()] = true;
            order_.push_back(std::uint16_t(path.back()));
        }
    }
}

void JointChain::pose(const Affine& root, std::span<const Vec3> rotations, std::span<Affine> bones) {
    assert(rest_.size() == parents_.size() && rotations.size() == parents_.size() && bones.size() == parents_.size());
    for (const std::uint16_t j : order_) {
        const Affine& parent = parents_[j] < 0 ? root : globals_[std::size_t(parents_[j])];
        globals_[j] = multiply(multiply(parent, rest_[j]), rotationBy(rotations[j]));
        bones[j] = multiply(globals_[j], inverse_bind_[j]);
    }
}

}  // namespace penumbra
