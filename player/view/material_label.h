#pragma once
#include <string>
#include <string_view>

namespace penumbra {

// Returns a material's name as a reader wants it: "ggx:alpha=0.3,f0=0.9" of penumbra-fit brdf --analytic becomes "GGX,
// alpha 0.3, f0 0.9". Names that are no such words stay.
std::string materialLabel(std::string_view name);

}  // namespace penumbra
