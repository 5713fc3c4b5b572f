#include "formats/provenance.h"

#include <nlohmann/json.hpp>

#include "formats/errors.h"
#include "formats/sha256.h"

namespace penumbra {
using Json = nlohmann::ordered_json;

std::string_view penumbraVersion() { return PENUMBRA_VERSION; }

Provenance makeProvenance(std::string tool, std::string options_json,
                          const std::vector<std::filesystem::path>& inputs) {
    Provenance provenance{std::move(tool), std::string(penumbraVersion()), std::move(options_json), {}};
    for (const std::filesystem::path& input : inputs)
        provenance.inputs.push_back({input.filename().string(), sha256OfFile(input)});
    return provenance;
}

std::string toJson(const Provenance& provenance) {
    Json json;
    json["tool"] = provenance.tool;
    json["version"] = provenance.version;
    json["options"] = provenance.options_json.empty() ? Json::object() : Json::parse(provenance.options_json);
    json["inputs"] = Json::array();
    for (const ProvenanceInput& input : provenance.inputs)
        json["inputs"].push_back(Json{{"name", input.name}, {"sha256", input.sha256}});
    // File names need not be UTF-8; JSON has to be.
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// nlohmann's parser recurses with the nesting depth; hostile text must not exhaust the stack.
static bool nestedTooDeep(std::string_view json) {
    int depth = 0;
    for (char c : json) {
        if (c == '[' || c == '{') ++depth;
        if (c == ']' || c == '}') --depth;
        if (depth > 64) return true;
    }
    return false;
}

Provenance provenanceFromJson(std::string_view json) try {
    if (nestedTooDeep(json)) throw InvalidInput("provenance: nested too deep");
    const Json parsed = Json::parse(json);
    Provenance provenance{
        parsed.at("tool").get<std::string>(), parsed.at("version").get<std::string>(), parsed.at("options").dump(), {}};
    if (!parsed.at("options").is_object()) throw InvalidInput("provenance: options is not an object");
    for (const Json& input : parsed.at("inputs"))
        provenance.inputs.push_back({input.at("name").get<std::string>(), input.at("sha256").get<std::string>()});
    return provenance;
} catch (const nlohmann::json::exception& error) {
    throw InvalidInput("provenance: " + std::string(error.what()));
}

}  // namespace penumbra
