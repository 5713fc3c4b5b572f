#pragma once
#include "formats/rig/source_look.h"

struct aiMaterial;

namespace penumbra {

// Reads what FBX, Collada and .x say of a material that ours can say, too: base or diffuse colour, emission, metalness
// and roughness where they are given, else the roughness of Phong's exponent, and the index of refraction. Everything
// else becomes a note.
SourceLook readAssimpLook(const aiMaterial& material);

}  // namespace penumbra
