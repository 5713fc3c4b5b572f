// Compiled with -mavx2 -mfma and contraction of a * b + c allowed, called only where the processor has them.
#include "player/runtime/shade_kernel.h"

#ifdef __AVX2__
#include "player/runtime/shade_lanes.h"

namespace penumbra {
namespace {

const ShadePath kPath{"avx2", shadeLanes};

}  // namespace
const ShadePath* const kShadeAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const ShadePath* const kShadeAvx2 = nullptr;
}

#endif
