#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// penumbra-player render X.pnb -o OUT.(png|exr): one frame as a picture.
Verb renderVerb();

}  // namespace penumbra
