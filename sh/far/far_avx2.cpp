// This file is compiled with -mavx2 -mfma -mf16c, and may contract a * b + c. Its functions are called only where the
// processor has these.
#include "sh/far/far_kernel.h"

#ifdef __AVX2__
#include "sh/far/far_lanes.h"

namespace penumbra {
namespace {

const FarPath kPath{anchorLanes, farLanes, composeLanes};

}  // namespace
const FarPath* const kFarAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const FarPath* const kFarAvx2 = nullptr;
}

#endif
