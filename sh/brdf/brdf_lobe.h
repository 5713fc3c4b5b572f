#pragma once
// Lobes of a material: analytic BRDFs that add up to it, for light from a single direction. An analytic material is one
// lobe, exactly. The lobes of a measured one are fitted (formats/brdf/fit_lobes.h). They are small enough to go to a
// shader as uniforms; runtime/glsl/brdf_glsl.h is the twin of this file.
#include <array>
#include <span>

#include "sh/brdf/brdf.h"

namespace penumbra {

constexpr int kMaxBrdfLobes = 4;  // limit for a material

struct BrdfLobe {
    BrdfModel model = BrdfModel::kLambert;
    std::array<float, 4> parameters{};  // parametersOf(model) first, then zeros
    Vec3 color{1, 1, 1};                // linear Rec.709, a factor on the model

    bool operator==(const BrdfLobe&) const = default;
};

BrdfLobe lobeOf(const BrdfSpec& spec);

// Tells whether the lobe can be evaluated: a known model, every parameter in its range, the rest 0, a colour that is
// finite and not negative.
bool isValid(const BrdfLobe& lobe);

// Returns the sum of all lobes but mirrors, f(wi, wo) in 1/sr without the cosine. Both directions are unit vectors of
// the local frame and point away from the surface; the sum is 0 where either is at or below the horizon. Lobes must be
// valid. It computes in double: the value of a narrow lobe near its peak hangs on the last bits of the directions.
Vec3 evalLobes(std::span<const BrdfLobe> lobes, Vec3 wi, Vec3 wo);

// Returns what all mirrors among the lobes reflect from (-wo.x, -wo.y, wo.z) to wo, a share of the radiance: color (f0
// + (1 - f0) (1 - wo.z)^5). 0 where wo is at or below the horizon.
Vec3 mirrorReflectance(std::span<const BrdfLobe> lobes, Vec3 wo);

}  // namespace penumbra
