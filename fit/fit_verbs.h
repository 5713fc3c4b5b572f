#pragma once
// The verbs of penumbra-fit. X_command.cpp holds the flags and the run of verb X.
#include "formats/common/command_line.h"

namespace penumbra {

Verb visibilityVerb();
Verb predictVerb();
Verb indirectVerb();
Verb brdfVerb();
Verb lightVerb();
Verb captureVerb();
Verb blockersVerb();
Verb pageVerb();
Verb posesVerb();
Verb cameraVerb();
Verb responseVerb();
Verb alignVerb();

}  // namespace penumbra
