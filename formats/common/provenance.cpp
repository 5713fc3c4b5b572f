#include "formats/common/provenance.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/common/errors.h"
#include "formats/common/json_depth.h"
#include "formats/common/program_version.h"
#include "formats/common/sha256.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

std::string program_version = PENUMBRA_VERSION;

}  // namespace

std::string_view penumbraVersion() { return PENUMBRA_VERSION; }
void setSourceHash(std::string_view hash) { program_version = PENUMBRA_VERSION "+" + std::string(hash); }
std::string programVersion() { return program_version; }

Provenance makeProvenance(std::string tool, std::string options_json,
                          const std::vector<std::filesystem::path>& inputs) {
    Provenance provenance{std::move(tool), programVersion(), std::move(options_json), {}};
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
    if (!provenance.notes.empty()) json["notes"] = provenance.notes;
    // File names need not be UTF-8, but JSON has to be.
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool nestedTooDeep(std::string_view json) {
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
    if (parsed.contains("notes")) provenance.notes = parsed["notes"].get<std::vector<std::string>>();
    return provenance;
} catch (const nlohmann::json::exception& error) {
    throw InvalidInput("provenance: " + std::string(error.what()));
}

namespace {

std::string textOf(const Json& options, const std::string& name) {
    return options.contains(name) ? options[name].dump(-1, ' ', false, Json::error_handler_t::replace) : "absent";
}

void compareOptions(const Json& other, const Json& expected, const std::vector<std::string>& ignored,
                    std::vector<std::string>& differences) {
    std::set<std::string> names;
    for (const Json& options : {other, expected})
        for (const auto& item : options.items()) names.insert(item.key());
    for (const std::string& name : ignored) names.erase(name);
    for (const std::string& name : names)
        if (const std::string a = textOf(other, name), b = textOf(expected, name); a != b)
            differences.push_back(name + " " + a + ", not " + b);
}

}  // namespace

std::vector<std::string> differencesOf(const Provenance& other, const Provenance& expected,
                                       const std::vector<std::string>& ignored_options) {
    std::vector<std::string> differences;
    if (other.tool != expected.tool) differences.push_back("made by " + other.tool + ", not " + expected.tool);
    if (other.version != expected.version)
        differences.push_back("version " + other.version + ", not " + expected.version);
    if (other.inputs.size() != expected.inputs.size())
        differences.push_back(std::to_string(other.inputs.size()) + " inputs, not " +
                              std::to_string(expected.inputs.size()));
    for (std::size_t i = 0; i < std::min(other.inputs.size(), expected.inputs.size()); ++i)
        if (other.inputs[i].sha256 != expected.inputs[i].sha256)
            differences.push_back("input " + other.inputs[i].name + " has SHA-256 " +
                                  other.inputs[i].sha256.substr(0, 12) + "..., not " +
                                  expected.inputs[i].sha256.substr(0, 12) + "...");
    compareOptions(Json::parse(other.options_json), Json::parse(expected.options_json), ignored_options, differences);
    return differences;
}

}  // namespace penumbra
