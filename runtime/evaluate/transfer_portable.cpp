#include "runtime/evaluate/transfer_lanes.h"
#include "sh/cpu_features.h"

namespace penumbra {

std::vector<TransferPath> transferPaths() {
    std::vector<TransferPath> paths = {{"portable", addTransferRows}};
    if (kTransferAvx2 && cpuHasAvx2()) paths.push_back(*kTransferAvx2);
    return paths;
}

}  // namespace penumbra
