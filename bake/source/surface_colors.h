#pragma once
// The colours of a surface, by which it reflects light and lets it through.
#include "bake/common/bake_options.h"
#include "bake/source/bake_source.h"

namespace penumbra {

// Reads "R/G/B", or else the name of a table. "" is no choice.
ColorChoice readColorChoice(const std::string& text);

// Returns the albedo of each vertex of `mesh` that a choice names. Throws what surfaceColors() throws.
std::vector<Vec3> readAlbedo(const ColorChoice& choice, const Mesh& mesh);

// This is what `albedo_from` says where no albedo is given.
constexpr const char* kFromBaseColors = "the rig's base colours";
constexpr const char* kFromTextures = "the rig's base colours and textures";

struct ChosenColors {
    SurfaceColors colors;
    std::string albedo_from;                      // where the albedo came from, in words
    std::vector<std::filesystem::path> pictures;  // the textures that were read
};

// Returns the colours of each vertex of `mesh`, which is the mesh of `source` and may have got backs. Without an
// albedo among the options the rig's own base colours and textures are the albedo. Throws BadOption, InvalidInput and
// Unsupported, which name what is wrong.
ChosenColors surfaceColors(const BakeSource& source, const Mesh& mesh, const TransferOptions& options);

}  // namespace penumbra
