#pragma once
// The verbs of penumbra-bake. X_command.cpp holds the flags and the run of verb X.
#include "formats/common/command_line.h"

namespace penumbra {

Verb visibilityVerb();
Verb fieldsVerb();
Verb mergeVerb();
Verb posesVerb();
Verb referenceVerb();
Verb infoVerb();

}  // namespace penumbra
