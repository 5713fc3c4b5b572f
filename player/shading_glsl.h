#pragma once
// shade() of evaluate.vert as GLSL, written out for one layout.
#include <string>

#include "player/shading_layout.h"

namespace penumbra {

// vec3 shade(vec4 numbers[STRIDE4], vec3 to_eye, mat3 local_from_model), with the declarations that it needs: samplers
// "materials" and "material_of_slot", uniform "slot_base", uniform block "Light", attribute 5 "slot".
std::string shadingGlsl(const ShadingLayout& layout);

// "numbers[2].w": number i of a vertex in numbersOf()'s array.
std::string numberGlsl(std::size_t i);

}  // namespace penumbra
