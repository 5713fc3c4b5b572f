#pragma once
// The verbs of penumbra-fit, one for each command.
#include "formats/common/command_line.h"

namespace penumbra {

Verb visibilityVerb();
Verb compareVerb();
Verb predictVerb();
Verb brdfVerb();
Verb lightVerb();

}  // namespace penumbra
