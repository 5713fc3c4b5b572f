#pragma once
// The verbs of penumbra-fit.
#include "formats/common/command_line.h"

namespace penumbra {

Verb visibilityVerb();
Verb compareVerb();
Verb predictVerb();
Verb brdfVerb();
Verb lightVerb();

}  // namespace penumbra
