#pragma once
// The verb `penumbra-pack check X.pnb TRUTH.vis.h5`.
#include "formats/common/command_line.h"

namespace penumbra {

Verb checkVerb();

}  // namespace penumbra
