#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// The verb `penumbra-bake reference X.vis.h5 --frame N -o REF.(exr|png)`, which renders by brute force what the
// player's pictures are compared with.
Verb referenceVerb();

}  // namespace penumbra
