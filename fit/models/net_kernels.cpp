#include "fit/models/net_kernels.h"

#include <cstdlib>

#include "fit/models/net_kernel_lanes.h"

namespace penumbra {

namespace {

bool cpuHasAvx2AndFma() {
#ifdef __x86_64__
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return false;
#endif
}

}  // namespace

std::vector<NetKernels> netKernelPaths() {
    std::vector<NetKernels> paths = {{"portable", addProductLanes, innerProductsLanes, tanhAndSlopeLanes}};
    if (kNetKernelsAvx2 && cpuHasAvx2AndFma() && !std::getenv("PENUMBRA_NO_SIMD")) paths.push_back(*kNetKernelsAvx2);
    return paths;
}

}  // namespace penumbra
