#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// The verb `penumbra-player render X.pnb -o OUT.(png|exr)`, which draws frames as pictures.
Verb renderVerb();

}  // namespace penumbra
