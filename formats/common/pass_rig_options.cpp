#include "formats/common/pass_rig_options.h"

#include <nlohmann/json.hpp>

namespace penumbra {

void passRigOptions(std::string_view options_json, nlohmann::ordered_json& json) {
    const auto all = nlohmann::ordered_json::parse(options_json, nullptr, false);
    if (!all.is_object()) return;
    if (all.contains("rig")) {
        json["rig"] = all.at("rig");
        return;
    }
    for (const char* key : {"nodes", "without", "split_angle", "crease", "sides"})
        if (all.contains(key)) json["rig"][key] = all.at(key);
}

}  // namespace penumbra
