// This file is compiled with -mavx2 -mfma and may contract a * b + c. Its code is called only on processors that have
// both.
#include "fit/models/net_kernels.h"

#ifdef __AVX2__
#include "fit/models/net_kernel_lanes.h"

namespace penumbra {
namespace {

const NetKernels kPath{"avx2", addProductLanes, innerProductsLanes, tanhAndSlopeLanes};

}  // namespace
const NetKernels* const kNetKernelsAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const NetKernels* const kNetKernelsAvx2 = nullptr;
}

#endif
