#pragma once
// Finds joints that hang together though the skeleton does not say so.
//
// Most joints turn about a point of their parent joint, or shift a little, like shoulders that shrug. Others slide:
// they are children of the root and controls move them, as the hands at the ends of some animators' arms. What such a
// joint carries hangs on another joint, or on nothing. Pairs of these must follow the same frame, or the character is
// torn.
#include <span>
#include <utility>
#include <vector>

#include "formats/rig/rig_poses.h"

namespace penumbra {

// Returns pairs of joints. A joint that slides by more than 15% of the rest diagonal in the space of its parent joint
// is paired with that one, and with the joint in whose space it slides least, if that is at most 2%. So is each root
// after the first. (Shoulders and hips of five characters shift by up to 9% of it. What tears slides by 20% and more,
// and by 1% seen from what it hangs on.) Only joints count that move vertices, themselves or through joints below, and
// of the joints that share a node the first. At most 256 frames are looked at, spread over all.
std::vector<std::pair<int, int>> attachedJoints(const Rig& rig, std::span<const RigFrame> frames, int threads);

}  // namespace penumbra
