#pragma once
// Writes SH functions as GLSL: straight lines of float arithmetic.
#include <string>
#include <string_view>

namespace penumbra {

// Returns a GLSL float literal that reads back as `value`.
std::string glslFloat(double value);

// Declares floats PREFIX0, PREFIX1, ... that hold y_i of the unit vec3 named `direction`, for i < order^2, or only
// for even l+m (the declared names keep the SH index i). Recurrences and signs are those of evalBasis().
std::string basisGlsl(int order, bool even_only, std::string_view prefix, std::string_view direction);

}  // namespace penumbra
