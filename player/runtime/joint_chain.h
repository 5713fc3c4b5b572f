#pragma once
// Skinning matrices from joint rotations, by the rest transforms of the asset.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

// False for files made before rest transforms were kept, and for rigs with a joint scaled to 0.
bool hasRestTransforms(const AnimationView& animation);

// Forward kinematics: G_j = G_parent T_j exp(r_j), of a root joint G_j = root T_j exp(r_j), and the skinning matrix is
// G_j B_j; T rest transform, B inverse bind. Exact where clips turn joints only and rest scales are uniform.
class JointChain {
public:
    explicit JointChain(const AnimationView& animation);
    // rotations: [J] rotation vectors relative to rest, radians; bones: [J]. Allocates nothing.
    void pose(const Affine& root, std::span<const Vec3> rotations, std::span<Affine> bones);

private:
    std::span<const std::int32_t> parents_;
    std::span<const Affine> rest_, inverse_bind_;
    std::vector<std::uint16_t> order_;  // parents before children
    std::vector<Affine> globals_;       // [J]
};

}  // namespace penumbra
