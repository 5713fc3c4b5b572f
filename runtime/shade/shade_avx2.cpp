// This file is compiled with -mavx2 -mfma, and may contract a * b + c. Its functions are called only where the
// processor has these.
#include "runtime/shade/shade_kernel.h"

#ifdef __AVX2__
#include "runtime/shade/shade_lanes.h"

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
