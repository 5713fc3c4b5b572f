#include "runtime/shade/shade_lanes.h"
#include "sh/cpu_features.h"

namespace penumbra {

std::vector<ShadePath> shadePaths() {
    std::vector<ShadePath> paths = {{"portable", shadeLanes}};
    if (kShadeAvx2 && cpuHasAvx2()) paths.push_back(*kShadeAvx2);
    return paths;
}

}  // namespace penumbra
