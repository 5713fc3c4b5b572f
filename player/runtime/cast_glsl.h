#pragma once
// Writes as GLSL what spheres hide from a point, for the shaders of engines (docs/formulas.md, section 10). It computes
// what castMirrored() (sh/cast/cast_visibility.h) and CastProduct compute on the CPU.
#include <string>
#include <vector>

#include "sh/visibility_convention.h"

namespace penumbra {

// Writes penumbra_cast_visibility(), penumbra_cast_mirror() and penumbra_cast_ambient(). The text tells what they do.
// It reads spheres as PENUMBRA_SPHERE(i) and capLogTexels() as PENUMBRA_CAP_LOG(texel), two macros that give a vec4.
std::string castGlsl();

// Writes void penumbra_cast_numbers(inout vec4 numbers[PENUMBRA_STRIDE4], float mirrored[21]). It calls what
// ambientGlsl() (shading_glsl.h) writes for the same convention.
std::string castNumbersGlsl(const Convention& convention);

// The rows of capLogTable() as texels: [kCapLogEntries, 2, 4].
std::vector<float> capLogTexels();

}  // namespace penumbra
