// This file is compiled with -mavx2 -mfma, and may contract a * b + c. Its functions are called only where the
// processor has these.
#include "player/bench/roofline.h"

#ifdef __AVX2__
#include "player/bench/roofline_kernels.h"

namespace penumbra {
namespace {

const RooflinePath kPath{"avx2", multiplyAdds, 2 * kChains* kRoofLanes, readAll, triad};

}  // namespace
const RooflinePath* const kRooflineAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const RooflinePath* const kRooflineAvx2 = nullptr;
}

#endif
