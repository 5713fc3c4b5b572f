#pragma once
// Writes as GLSL what spheres and fields hide from a point (docs/formulas.md, sections 8 and 10). It computes what
// CastShadow and CastProduct compute on the CPU.
#include <string>
#include <vector>

#include "sh/visibility_convention.h"

namespace penumbra {

// Writes penumbra_cast_ambient() and penumbra_cast_clamp(); where the shader defines PENUMBRA_SPHERE and
// PENUMBRA_CAP_LOG, penumbra_cast_visibility() and penumbra_cast_mirror(); and where it defines PENUMBRA_PART and
// PENUMBRA_FIELD, penumbra_cast_fields() and penumbra_cast_combine(). The text tells what they do, and what the macros
// give.
std::string castGlsl();
// Writes the first two alone.
std::string castAmbientGlsl();

// Writes void penumbra_cast_coefficients(inout vec4 numbers[PENUMBRA_STRIDE4], float mirrored[21]). It calls what
// ambientGlsl() (shading_glsl.h) writes for the same convention.
std::string castCoefficientsGlsl(const Convention& convention);

// The rows of capLogTable() as texels: [kCapLogEntries, 2, 4].
std::vector<float> capLogTexels();

}  // namespace penumbra
