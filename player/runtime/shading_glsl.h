#pragma once
// What a shader computes of E and of radiance, as GLSL written out for one convention and one layout; the player's own
// shader and those of engines (penumbra.glsl) call it. Texts need PENUMBRA_STRIDE4, vec4 a vertex.
#include <string>

#include "player/runtime/shading_layout.h"

namespace penumbra {

// float penumbra_ambient(vec4 numbers[PENUMBRA_STRIDE4]), void penumbra_clamp_ambient(inout vec4 numbers[...]).
std::string ambientGlsl(const Convention& convention);

// vec3 penumbra_shade(vec4 numbers[PENUMBRA_STRIDE4], vec3 to_eye, mat3 local_from_model, int material). Reads texels
// of materialData() as PENUMBRA_MATERIAL(i) and of writeLightData() as PENUMBRA_LIGHT(i): macros that give a vec4.
std::string shadingGlsl(const ShadingLayout& layout);

}  // namespace penumbra
