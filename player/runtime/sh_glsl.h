#pragma once
// SH functions as GLSL: straight lines of float arithmetic.
#include <string>
#include <string_view>

namespace penumbra {

// A GLSL float literal that reads back as `value`.
std::string glslFloat(double value);

// Declares floats PREFIX0, PREFIX1, ... of the unit vec3 named `direction`: y_i for i < order^2, or only those with
// l+m even (the declared names keep the SH index i). Same recurrences and signs as evalBasis().
std::string basisGlsl(int order, bool even_only, std::string_view prefix, std::string_view direction);

}  // namespace penumbra
