#include "sh/brdf/brdf_lobe.h"

#include <cmath>

#include "sh/brdf/fresnel.h"

namespace penumbra {

BrdfLobe lobeOf(const BrdfSpec& spec) {
    BrdfLobe lobe{modelOf(spec), {}, toFloat(spec.color)};
    const std::array<double, 4> parameters = brdfFunction(spec).parameters;
    for (std::size_t i = 0; i < parameters.size(); ++i) lobe.parameters[i] = float(parameters[i]);
    return lobe;
}

bool isValid(const BrdfLobe& lobe) {
    if (int(lobe.model) >= kBrdfModels) return false;
    const std::span<const BrdfParameter> known = parametersOf(lobe.model);
    for (std::size_t i = 0; i < lobe.parameters.size(); ++i) {
        // The limits are rounded as the parameter was, so that a parameter at its limit passes.
        const float least = i < known.size() ? float(known[i].least) : 0,
                    most = i < known.size() ? float(known[i].most) : 0;
        if (!(lobe.parameters[i] >= least && lobe.parameters[i] <= most)) return false;
    }
    for (int c = 0; c < 3; ++c)
        if (!(std::isfinite(lobe.color[c]) && lobe.color[c] >= 0)) return false;
    return true;
}

Vec3 evalLobes(std::span<const BrdfLobe> lobes, Vec3 wi, Vec3 wo) {
    // A length that is off by 6e-8 would change the highest powers by half a percent.
    const Vec3d i = normalized(toDouble(wi)), o = normalized(toDouble(wo));
    Vec3d sum;
    for (const BrdfLobe& lobe : lobes) {
        if (lobe.model == BrdfModel::kMirror) continue;
        const auto& p = lobe.parameters;
        sum += toDouble(lobe.color) * brdfFunction(lobe.model, {p[0], p[1], p[2], p[3]})(i, o);
    }
    return toFloat(sum);
}

Vec3 mirrorReflectance(std::span<const BrdfLobe> lobes, Vec3 wo) {
    Vec3 sum;
    if (!(wo.z > 0)) return sum;
    for (const BrdfLobe& lobe : lobes)
        if (lobe.model == BrdfModel::kMirror) sum += lobe.color * float(schlickFresnel(wo.z, lobe.parameters[0]));
    return sum;
}

}  // namespace penumbra
