// Part of penumbra_arrays, which reads numbered files without anything of rigs.
#include <algorithm>
#include <cctype>

#include "formats/rig/rig_build.h"

namespace penumbra {

bool isExtension(const std::filesystem::path& file, const char* extension) {
    std::string own = file.extension().string();
    std::transform(own.begin(), own.end(), own.begin(), [](unsigned char c) { return std::tolower(c); });
    return own == extension;
}

}  // namespace penumbra
