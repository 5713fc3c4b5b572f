#pragma once
#include "formats/common/command_line.h"

namespace penumbra {

Verb viewVerb();

}  // namespace penumbra
