#pragma once
// The albedo of a rig from its own materials: base colour times texture times vertex colour, one colour a vertex.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/rig/rig_file.h"

namespace penumbra {

struct BaseColors {
    std::vector<Vec3> colors;  // [V] of the rig's mesh, linear Rec.709
    bool textured = false;
    std::vector<std::filesystem::path> pictures;  // the files that were read for it
};

// `file` names the rig in messages. Throws UsageError for a slot without a colour, and the errors of decodeTexture(),
// which name slot and picture.
BaseColors readBaseColors(const Rig& rig, const std::string& file);

}  // namespace penumbra
