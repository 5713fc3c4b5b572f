#pragma once
// Writes SH functions as GLSL: straight lines of float arithmetic.
#include <string>
#include <string_view>

namespace penumbra {

// Returns a GLSL float literal that reads back as `value`.
std::string glslFloat(double value);

enum class BasisPart { kAll, kEven };  // kEven: only y_lm with an even l+m
// Declares floats PREFIX0, PREFIX1, ... that hold y_i of the unit vec3 named `direction`, for i < order^2
// of this part (the declared names keep the SH index i). Recurrences and signs are those of evalBasis().
std::string basisGlsl(int order, BasisPart part, std::string_view prefix, std::string_view direction);

}  // namespace penumbra
