#include "fit/models/net_kernels.h"

#include "fit/models/net_kernel_lanes.h"
#include "sh/cpu_features.h"

namespace penumbra {

std::vector<NetKernels> netKernelPaths() {
    std::vector<NetKernels> paths = {{"portable", addProductLanes, innerProductsLanes, tanhAndSlopeLanes}};
    if (kNetKernelsAvx2 && cpuHasAvx2()) paths.push_back(*kNetKernelsAvx2);
    return paths;
}

}  // namespace penumbra
