#pragma once
// Finds the limbs of a skeleton: arms, legs, neck and head, tail, trunk. It also finds which limb is the mirror image
// of which. Limbs are what a pose can be put together from, because what one does says little about another.
//
// A joint is a fork when at least two of its child subtrees reach far. Each of these subtrees is a limb, in which
// further forks cut. What no fork cuts off is the trunk, limb 0. A subtree reaches from the origin of its first joint
// to the farthest vertex that one of its joints dominates. At least 6% of the rest diagonal is far. So arms and a head
// are limbs, but fingers, ears and bones without vertices (targets, controls) are not. Nor is a twist bone: a single
// joint whose vertices all lie nearer to the fork than the next joint of the chain.
//
// All places are those of the rest space, in which the skin binds the vertices. So the pose in which the file stands
// does not matter.
#include <span>
#include <vector>

#include "formats/rig/rig_poses.h"

namespace penumbra {

struct Limbs {
    std::vector<int> limb_of_joint;  // [J]
    // Limb of each node [N]. A joint's node has the joint's limb. A node between joints belongs to the limb of all
    // joints below it, or to the limb of the joint above if they differ.
    std::vector<int> limb_of_node;
    std::size_t count = 1;
    std::vector<char> carries;  // [J] carryingJoints()

    // The rest space is mirrored at a plane perpendicular to x, y or z.
    Matrix reflection = kIdentityMatrix;
    std::vector<int> mirrored_joint;  // [J], itself in the plane; -1: none
    // [count], itself for a limb in the plane. -1 where a joint of the limb that carries vertices has no image, or
    // where the images do not form a limb with the same tree of joints.
    std::vector<int> mirrored_limb;

    std::size_t mirroredCount() const;
};

// Finds the limbs. Those that hang together in `frames` though the skeleton does not say so (attached_joints.h) become
// one limb.
Limbs findLimbs(const Rig& rig, std::span<const RigFrame> frames, int threads);

// Returns [J] 1 where a joint or one below it moves vertices. Of the joints that share a node only the first counts.
std::vector<char> carryingJoints(const Rig& rig);

}  // namespace penumbra
