// This file is compiled with -mavx2 -mfma -mf16c, and may contract a * b + c. Its functions are called only where the
// processor has these.
#include "sh/cast/cast_kernel.h"

#ifdef __AVX2__
#include "sh/cast/cast_lanes.h"

namespace penumbra {
namespace {

const CastPath kPath{castLanes, castAnchorLanes};

}  // namespace
const CastPath* const kCastAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const CastPath* const kCastAvx2 = nullptr;
}

#endif
