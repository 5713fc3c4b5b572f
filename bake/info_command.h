#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// The verb `penumbra-bake info FILE`, which tells what a Penumbra file of any kind holds, who made it and from what.
Verb infoVerb();

}  // namespace penumbra
