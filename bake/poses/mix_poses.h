#pragma once
// Mixes poses: each limb is posed as in one random frame, so that limbs come together that no clip shows together.
//
// A model that has seen an arm move only along with one leg cannot tell whose shadow it sees. Mixed poses part the two,
// and each limb still moves as the clips have it. Where the skeleton is symmetric, half of the limbs take the mirror
// image of what the limb on the other side does.
//
// The mirror image of a limb: let M_j be the skinning matrix of joint j in the frame (rest space to model space), B_j
// its inverse bind matrix, p its parent joint, m the image of j, and S the reflection of the rest space. D = M_p(m)^-1
// M_m moves the image against its parent, so S D S moves j against p. With K the transforms of the nodes between the
// two, the node of j gets the transform K^-1 B_p S D S B_j^-1. Where j has no parent joint, the skinning matrix A that
// j has at rest stands for M_p and M_p(m), and B_p is the identity: D = A^-1 M_m, and the node gets K^-1 A S D S
// B_j^-1.
#include "bake/poses/limbs.h"
#include "formats/rig/rig_poses.h"

namespace penumbra {

// What poses are mixed from. At least one frame.
struct MixSource {
    const Rig& rig;
    const Limbs& limbs;
    std::span<const RigFrame> frames;
};

// One limb's part in a pose: the frame that it follows, as an index into the frames, and whether it is the mirror image
// of what its image does there.
struct LimbChoice {
    std::size_t frame = 0;
    bool mirrored = false;
    bool operator==(const LimbChoice&) const = default;
};
// Draws the parts of mixed pose `index` [limbs]. They depend on nothing else than the seed, the index and the counts.
std::vector<LimbChoice> chooseLimbs(const MixSource& source, std::uint64_t seed, std::size_t index);

// Puts the transforms of all nodes together. A limb whose mirror image cannot be told by translation, rotation and
// scale (they would have to shear) follows its frame without a mirror.
std::vector<NodePose> mixPose(const MixSource& source, std::span<const LimbChoice> choices);

// Mixes poses 0, 1, ... count - 1: [count, N, kNodeValues]. So a shorter list is a prefix of a longer one. The poses
// are the same for any number of threads. Throws UsageError when they would take more than 2 GiB.
std::vector<float> mixPoses(const MixSource& source, std::size_t count, std::uint64_t seed, int threads);

}  // namespace penumbra
