#pragma once
#include "formats/command_line.h"

namespace penumbra {

Verb viewVerb();

}  // namespace penumbra
