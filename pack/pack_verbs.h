#pragma once
// The verbs of penumbra-pack. X_command.cpp holds the flags and the run of verb X.
#include "formats/common/command_line.h"

namespace penumbra {

Verb assetVerb();
Verb truthVerb();
Verb checkVerb();
Verb exportVerb();
Verb embedVerb();

}  // namespace penumbra
