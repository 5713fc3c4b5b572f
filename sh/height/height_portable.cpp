#include "sh/cpu_features.h"
#include "sh/height/height_lanes.h"

namespace penumbra {

const HeightPath kHeightPortable{"portable", visibilityLanes, mirrorLanes, blendLanes};

const HeightPath& fastestHeightPath() { return kHeightAvx2 && cpuHasAvx2() ? *kHeightAvx2 : kHeightPortable; }

}  // namespace penumbra
