#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// penumbra-bake poses RIG... -o POSES.(h5|glb): the most different frames of many clips, and sampled poses.
Verb posesVerb();

}  // namespace penumbra
