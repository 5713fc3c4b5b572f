#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// penumbra-player bench X.pnb: milliseconds a frame on this machine.
Verb benchVerb();

}  // namespace penumbra
