#include "fit/fit_light.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "formats/project_map.h"

namespace penumbra {

LightFile fitLight(const EnvironmentMap& map, const std::string& name, int order, int threads) {
    MapProjection projection = projectMap(map, order, threads);
    LightFile light;
    light.name = std::filesystem::path(name).filename().string();
    light.order = order;
    light.sh = std::move(projection.sh);
    // The projection is orthogonal: |L - SH|^2 = |L|^2 - |SH|^2.
    const double kept = std::inner_product(light.sh.begin(), light.sh.end(), light.sh.begin(), 0.0);
    light.residual = projection.energy > 0 ? std::sqrt(std::max(0.0, 1 - kept / projection.energy)) : 0;
    return light;
}

}  // namespace penumbra
