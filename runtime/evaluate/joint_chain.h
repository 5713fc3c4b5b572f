#pragma once
// Computes skinning matrices from joint rotations by the rest transforms of the asset.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

// Returns false for files that were made before rest transforms were kept, and for rigs with a joint that is scaled
// to 0.
bool hasRestTransforms(const AnimationView& animation);

// Forward kinematics: G_j = G_parent T_j exp(r_j), and for a root joint G_j = root T_j exp(r_j). The skinning matrix
// is G_j B_j. T is the rest transform, B the inverse bind matrix. The result is exact where clips only turn joints and
// rest scales are uniform.
class JointChain {
public:
    explicit JointChain(const AnimationView& animation);
    // rotations: [J] rotation vectors relative to rest, in radians; bones: [J] results. Allocates nothing.
    void pose(const Affine& root, std::span<const Vec3> rotations, std::span<Affine> bones);

private:
    std::span<const std::int32_t> parents_;
    std::span<const Affine> rest_, inverse_bind_;
    std::vector<std::uint16_t> order_;  // parents stand before children
    std::vector<Affine> globals_;       // [J]
};

}  // namespace penumbra
