#include "player/runtime/far_lanes.h"

namespace penumbra {

const FarPath kFarPortable{anchorLanes, farLanes, composeLanes};

}  // namespace penumbra
