#pragma once
// The verb `penumbra-bake merge SHARD.vis.h5... -o X.vis.h5`.
#include "formats/common/command_line.h"

namespace penumbra {

Verb mergeVerb();

}  // namespace penumbra
