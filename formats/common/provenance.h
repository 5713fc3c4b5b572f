#pragma once
// Tells who made a file, from what and how. This content, and no time stamp, decides whether a file is made again.
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
    std::string version;  // version of Penumbra
    // An object with every option that changes the result, defaults included, but without threads and paths.
    std::string
        options_json;  // an object: every option that changes the result, defaults included; no threads, no paths
    std::vector<ProvenanceInput> inputs;
    std::vector<std::string> notes = {};  // deviations from the inputs that their readers report, one line each
};

std::string_view penumbraVersion();
Provenance makeProvenance(std::string tool, std::string options_json, const std::vector<std::filesystem::path>& inputs);
std::string toJson(const Provenance& provenance);      // one line, keys in a fixed order
Provenance provenanceFromJson(std::string_view json);  // throws InvalidInput

// Lists how `other` differs from `expected` in tool, version, content of the inputs (whatever their names) and
// options other than `ignored_options`, such as "rays 64, not 128". Empty when they do not differ.
std::vector<std::string> differencesOf(const Provenance& other, const Provenance& expected,
                                       const std::vector<std::string>& ignored_options);

}  // namespace penumbra
