#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// penumbra-bake info FILE: what is in a Penumbra file of any kind, who made it and from what.
Verb infoVerb();

}  // namespace penumbra
