#pragma once
// Which way the axes of a clip's file point, where its format does not say it.
#include <vector>

#include "formats/rig/rig_build.h"

namespace penumbra {

// Turns the places and the clips of `from` to the axes of the rig, where the long bones of both point the same ways
// after one turn that takes axes to axes, and after no other. A note tells the axes. `clip_of[n]` is the node of `from`
// that moves node n of the rig, or -1. The nodes of `from` stand without rotations and scales, as those of BVH do.
// Throws InvalidInput where a joint hangs on another one in the clip's file.
void turnToRig(RigSource& rig, RigSource& from, const std::vector<int>& clip_of);

}  // namespace penumbra
