#pragma once
// Writes the computation of E and of radiance as GLSL for one convention and one layout. The player's own shader and
// those of engines (penumbra.glsl) call it. The texts need PENUMBRA_STRIDE4, the number of vec4 that a vertex has.
#include <string>

#include "runtime/shade/shading_layout.h"

namespace penumbra {

// Writes float penumbra_ambient(vec4 numbers[PENUMBRA_STRIDE4]) and void penumbra_clamp_ambient(inout vec4
// numbers[...]).
std::string ambientGlsl(const Convention& convention);

// Writes void penumbra_add_point(vec4 point[PENUMBRA_STRIDE4], vec2 turn, float weight, inout vec4 numbers[...]), which
// adds the numbers of a point to those of a vertex that follows it. `turn` is that of penumbra_turn() (penumbra.glsl).
std::string followGlsl(const Convention& convention);

// Writes float penumbra_sight(vec4 numbers[PENUMBRA_STRIDE4], vec3 direction), which is V in a direction of the local
// frame (a unit vector).
std::string sightGlsl(const Convention& convention);

// Writes vec3 penumbra_shade(vec4 numbers[PENUMBRA_STRIDE4], vec3 to_eye, mat3 local_from_model, int material). It
// reads texels of materialData() as PENUMBRA_MATERIAL(i) and of writeLightData() as PENUMBRA_LIGHT(i), two macros
// that give a vec4. Where light bounces, there are also vec3 penumbra_bounced() and vec3
// penumbra_shade_bounced(numbers, vec4 indirect[3], to_eye, local_from_model, material).
std::string shadingGlsl(const ShadingLayout& layout);

}  // namespace penumbra
