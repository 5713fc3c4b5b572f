#include "player/runtime/far_lanes.h"

namespace penumbra {

const FarPath kFarPortable{farLanes, composeLanes};

}  // namespace penumbra
