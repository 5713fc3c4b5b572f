#include "sh/cpu_features.h"
#include "sh/far/far_lanes.h"

namespace penumbra {

const FarPath kFarPortable{anchorLanes, farLanes, composeLanes};

const FarPath& fastestFarPath() {
    if (kFarAvx512 && cpuHasVnni()) return *kFarAvx512;
    return kFarAvx2 && cpuHasAvx2() ? *kFarAvx2 : kFarPortable;
}

}  // namespace penumbra
