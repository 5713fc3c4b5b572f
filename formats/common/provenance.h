#pragma once
// Who made a file, from what and how: a rerun is decided by this content and not by time stamps.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

struct ProvenanceInput {
    std::string name;  // file name without folders, so that the same inputs give the same bytes anywhere
    std::string sha256;
};

struct Provenance {
    std::string tool;     // "penumbra-bake visibility"
    std::string version;  // of Penumbra
    std::string
        options_json;  // an object: every option that changes the result, defaults included; no threads, no paths
    std::vector<ProvenanceInput> inputs;
};

std::string_view penumbraVersion();
Provenance makeProvenance(std::string tool, std::string options_json, const std::vector<std::filesystem::path>& inputs);
std::string toJson(const Provenance& provenance);      // one line, keys in a fixed order
Provenance provenanceFromJson(std::string_view json);  // InvalidInput

// How `other` differs from `expected` in tool, version, content of the inputs (whatever their names) and options other
// than `ignored`: "rays 64, not 128" and the like; empty when in nothing.
std::vector<std::string> differencesOf(const Provenance& other, const Provenance& expected,
                                       const std::vector<std::string>& ignored_options);

}  // namespace penumbra
