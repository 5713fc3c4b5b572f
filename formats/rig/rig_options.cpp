#include "formats/rig/rig_options.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "formats/rig/rig_options_json.h"

namespace penumbra {

void listRigOptions(const RigOptions& options, nlohmann::ordered_json& json) {
    const RigOptions defaults;
    if (!options.nodes.empty()) json["nodes"] = options.nodes;
    if (!options.without.empty()) json["without"] = options.without;
    if (options.split_angle != defaults.split_angle) json["split_angle"] = options.split_angle;
    if (options.crease) json["crease"] = *options.crease;
    if (options.sides == RigSides::kFronts) json["sides"] = "fronts";
}

namespace {

using OptionsJson = nlohmann::ordered_json;

double angleOption(const OptionsJson& value, const char* name) {
    const double degrees = value.get<double>();
    if (!(degrees >= 0 && degrees <= 180)) throw InvalidInput(std::string("its option ") + name + " is out of 0..180");
    return degrees;
}

}  // namespace

RigOptions rigOptionsOf(std::string_view options_json) try {
    if (options_json.empty()) return {};
    const OptionsJson all = OptionsJson::parse(options_json);
    if (!all.is_object()) return {};
    const OptionsJson& json = all.contains("rig") ? all.at("rig") : all;
    RigOptions out;
    if (json.contains("nodes")) out.nodes = json.at("nodes").get<std::vector<std::string>>();
    if (json.contains("without")) out.without = json.at("without").get<std::vector<std::string>>();
    if (json.contains("split_angle")) out.split_angle = angleOption(json.at("split_angle"), "split_angle");
    if (json.contains("crease")) out.crease = angleOption(json.at("crease"), "crease");
    if (json.contains("sides")) out.sides = RigSides::kFronts;
    return out;
} catch (const nlohmann::json::exception&) {
    throw InvalidInput("its provenance has damaged options");
}

}  // namespace penumbra
