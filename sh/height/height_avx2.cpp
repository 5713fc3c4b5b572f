// This file is compiled with -mavx2 -mfma, and may contract a * b + c. Its functions are called only where the
// processor has these.
#include "sh/height/height_kernel.h"

#ifdef __AVX2__
#include "sh/height/height_lanes.h"

namespace penumbra {
namespace {

const HeightPath kPath{"avx2", visibilityLanes, mirrorLanes, blendLanes};

}  // namespace
const HeightPath* const kHeightAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const HeightPath* const kHeightAvx2 = nullptr;
}

#endif
