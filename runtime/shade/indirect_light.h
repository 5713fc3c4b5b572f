#pragma once
// Light that bounces, for shading (docs/formulas.md, section 15): the light as it meets indirect transfer, and the
// ambient visibility with bounces.
#include <array>
#include <span>

#include "runtime/shade/shade_kernel.h"
#include "sh/indirect_coefficients.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// What a picture shows of the light that reaches a character: from the environment, from the character itself by
// reflection, or both.
enum class Bounces { kBoth, kDirect, kIndirect };

// Makes what the shading kernel reads of a light, bands 0..2 in the model frame.
std::array<Vec3, kBouncedLight> makeBouncedLight(const ColorAxes& axes,
                                                 std::span<const Vec3, kIndirectCoefficients> light);

// Returns the weights of the coefficients 0, 9 and 10 of a vertex (sh/indirect_coefficients.h) that give the luminance
// of E_ind / pi under a light of radiance 1 from everywhere.
Vec3 bouncedAmbientWeights(const ColorAxes& axes);

// Adds to e [V], the ambient visibility, what vertices get by reflection under a light of radiance 1 from everywhere:
// the luminance of E_ind / pi. `indirect` is [V, kIndirectStride]. The sum is clamped to [0, 1].
void addBouncedAmbient(const ColorAxes& axes, std::span<const float> indirect, std::span<float> e);

// Multiplies the light that bounces to vertices [n, kIndirectStride] by the share of a white sky that others leave
// them: E of `mirrored` [n, kFarCoefficients], as CastShadow::evaluate() has it.
void castOnIndirect(std::span<const float> mirrored, std::span<float> indirect);

}  // namespace penumbra
