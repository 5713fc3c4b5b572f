// This file is compiled with AVX-512 VL on top of AVX2, FMA and F16C, and may contract a * b + c. Its functions are
// called only where the processor has these. There are twice as many registers, which takes a sixth of the time of
// far_avx2.cpp away; they stay 256 bits wide.
#include "sh/far/far_kernel.h"

#ifdef __AVX512VL__
#include "sh/far/far_lanes.h"

namespace penumbra {
namespace {

const FarPath kPath{anchorLanes, farLanes, composeLanes};

}  // namespace
const FarPath* const kFarAvx512 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const FarPath* const kFarAvx512 = nullptr;
}

#endif
