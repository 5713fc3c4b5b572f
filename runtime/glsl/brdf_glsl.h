#pragma once
// Writes as GLSL what evalLobes() (sh/brdf/brdf_lobe.h) computes on the CPU, for shaders that light pixels by single
// directions. The text needs GLSL 3.30 or later.
#include <cstdint>
#include <string>

#include "sh/brdf/brdf.h"

namespace penumbra {

// A set of models: bit i is the model with that number.
using BrdfModels = std::uint32_t;
constexpr BrdfModels kAllBrdfModels = (1u << kBrdfModels) - 1;

// Writes two functions and their helpers. Lobes of models that are not in the set give 0. A small set is worth it on
// software GL, which goes through all branches. Directions are unit vectors of the local frame, with z along the
// normal.
//   vec3 penumbra_brdf_lobe(int model, vec4 parameters, vec3 color, vec3 wi, vec3 wo)
//     f(wi, wo) of one lobe in 1/sr without the cosine; 0 at and below the horizon, of a mirror and of unknown models.
//   vec3 penumbra_mirror_reflectance(int model, vec4 parameters, vec3 color, vec3 wo)
//     the share of the radiance that a mirror reflects to wo; 0 of all other models.
std::string brdfGlsl(BrdfModels models = kAllBrdfModels);

}  // namespace penumbra
