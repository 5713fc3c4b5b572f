#pragma once
// Takes the options by which a bake read its rig along to the files that are made of it. Who reads the rig again
// (formats/rig/rig_options_json.h) reads it in the same way.
#include <nlohmann/json_fwd.hpp>
#include <string_view>

namespace penumbra {

// Adds the rig options among those of a provenance, or those that it took along, to `json` as "rig". Adds nothing where
// all are the default, which no stage lists.
void passRigOptions(std::string_view options_json, nlohmann::ordered_json& json);

}  // namespace penumbra
