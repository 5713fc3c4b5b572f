#include "sh/cast/cast_lanes.h"
#include "sh/cpu_features.h"

namespace penumbra {

const CastPath kCastPortable{castLanes, castAnchorLanes};

const CastPath& fastestCastPath() { return kCastAvx2 && cpuHasAvx2() ? *kCastAvx2 : kCastPortable; }

}  // namespace penumbra
