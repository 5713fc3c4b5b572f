#pragma once
// Moves the clips of one skeleton to another one that has the same rest pose, but maybe another unit, other axes, other
// lengths of its bones, and other nodes between its joints.
//
// For a joint let M be the rest transform from its parent node to its nearest ancestor that is matched too (or to the
// scene), and D the rotation from the axes of the clip's joint at rest to those of the rig's joint, seen from the
// former. Then the rig's joint shall turn as the clip's joint does:
//
//   rotation    q = m_rig^-1 D_parent^-1 m_clip  q_clip  D             (m: the rotation of M)
//   position    p = M_rig^-1 ( k D_parent^-1 (M_clip p_clip) )         (k: ratio of sizes, over that of the frames)
//
// Both are linear in the values of a key, so that keys stay keys, whatever is between them. The joints at the top take
// positions as above. All others take what the clip adds to the rest position, so that bones keep their lengths.
#include <vector>

#include "formats/rig/rig_build.h"

namespace penumbra {

class Retarget {
public:
    // `clip_of[n]` is the node of `from` that moves node n of `rig`, or -1. Throws InvalidInput where the two rest
    // poses differ by more than size, axes and lengths of bones, with the joints and by how much they differ. Pushes
    // notes of what differs into `rig`.
    Retarget(RigSource& rig, const RigSource& from, std::vector<int> clip_of);

    // Returns a channel of `from` as one of node n of the rig.
    Channel channelOf(const Channel& channel, int n) const;

private:
    struct Joint {
        Quaternion before{0, 0, 0, 1}, after{0, 0, 0, 1};  // rotation = before x q x after
        Matrix position = kIdentityMatrix;
        std::array<double, 3> scale{1, 1, 1};
    };
    std::vector<Joint> joints_;  // [node of the rig]
};

}  // namespace penumbra
