#pragma once
// Reads the options by which a bake read its rig, so that who reads the rig again reads it in the same way.
#include <string_view>

#include "formats/rig/rig_options.h"

namespace penumbra {

// Returns what listRigOptions() listed among the options of a bake, or what passRigOptions() took along
// (formats/common). `options_json` is that of a provenance. Options of another kind, or none, give the defaults. Throws
// InvalidInput where one has another type or lies out of its range.
RigOptions rigOptionsOf(std::string_view options_json);

}  // namespace penumbra
