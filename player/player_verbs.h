#pragma once
// The verbs of penumbra-player. X_command.cpp holds the flags and the run of verb X.
#include "formats/common/command_line.h"

namespace penumbra {

Verb viewVerb();
Verb renderVerb();
Verb measureVerb();
Verb benchVerb();
Verb probeVerb();
Verb compositeVerb();

}  // namespace penumbra
