#include "fit/reflectance/lobe_error.h"

#include <cmath>

#include "fit/reflectance/shading_error.h"

namespace penumbra {

double lobeError(const RgbBrdf& source, std::span<const BrdfLobe> lobes, int threads) {
    const RgbBrdf sum{"lobes", BrdfSymmetry::kOrthotropic,
                      [lobes](Vec3d wi, Vec3d wo) { return toDouble(evalLobes(lobes, toFloat(wi), toFloat(wo))); }};
    const ShadingTest test = makeShadingTest(referenceScenes(), threads);
    const std::vector<double> truth = bruteForceRadiance(test, source, threads),
                              ours = bruteForceRadiance(test, sum, threads);
    double error = 0, total = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        error += (ours[i] - truth[i]) * (ours[i] - truth[i]);
        total += truth[i] * truth[i];
    }
    return total > 0 ? std::sqrt(error / total) : 0;
}

}  // namespace penumbra
