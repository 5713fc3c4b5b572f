#include "player/papers/folded_light.h"

#include "player/papers/cast_shader.h"
#include "sh/zonal.h"

namespace penumbra {

FoldedLight::FoldedLight(CastMode mode, const LightView* light, const Mat3d& rotation) {
    if (light && (mode == CastMode::kFolded || mode == CastMode::kHemisphereShare))
        fold_ = makeCastFold(light->order, turnedLight(*light, rotation), castOrderOf(mode));
}

std::optional<Vec3d> FoldedLight::irradiance(std::span<const float> cast, Vec3 normal) const {
    if (fold_.matrix.empty()) return std::nullopt;
    const std::size_t n = std::size_t(coefficientCount(fold_.light_order));
    std::vector<float> folded(3 * n);
    foldCast(fold_, cast, folded);
    std::vector<double> zonal(std::size_t(fold_.light_order)), cosine(n);
    clampedCosineZonal(zonal);
    rotateZonal(zonal, toDouble(normal), cosine);
    Vec3d sum;
    for (std::size_t i = 0; i < folded.size(); ++i) sum[int(i % 3)] += cosine[i / 3] * double(folded[i]);
    return sum;
}

}  // namespace penumbra
