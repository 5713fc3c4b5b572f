#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

// The verb `penumbra-player bench X.pnb`, which prints milliseconds a frame on this machine.
Verb benchVerb();

}  // namespace penumbra
