#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// penumbra-bake reference X.vis.h5 --frame N -o REF.(exr|png): brute force, to hold the player's pictures against.
Verb referenceVerb();

}  // namespace penumbra
