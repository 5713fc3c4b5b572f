#include "formats/rig/rig_options.h"

#include <nlohmann/json.hpp>

namespace penumbra {

void listRigOptions(const RigOptions& options, nlohmann::ordered_json& json) {
    const RigOptions defaults;
    if (!options.nodes.empty()) json["nodes"] = options.nodes;
    if (!options.without.empty()) json["without"] = options.without;
    if (options.split_angle != defaults.split_angle) json["split_angle"] = options.split_angle;
    if (options.crease) json["crease"] = *options.crease;
    if (options.sides == RigSides::kFronts) json["sides"] = "fronts";
}

}  // namespace penumbra
