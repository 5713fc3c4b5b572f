#pragma once
// Every format of our files has one version, and a reader refuses all others (formats/README.md).
#include <cstdint>
#include <string>

namespace penumbra {

struct FileFormat {
    const char* name;  // "penumbra.model"
    int version;
};

// Returns "" for the version that this build reads, and otherwise what is wrong with the file and what to do.
inline std::string findVersionProblem(const FileFormat& format, std::int64_t found) {
    if (found == format.version) return "";
    return "is version " + std::to_string(found) + " of " + format.name + ", and this build reads version " +
           std::to_string(format.version) + " alone: make the file again with this build";
}

}  // namespace penumbra
