#pragma once
// The colours of a surface, by which it reflects light and lets it through.
#include "bake/common/bake_options.h"
#include "bake/source/bake_source.h"

namespace penumbra {

// Reads "R/G/B", or else the name of a table. "" is no choice.
ColorChoice readColorChoice(const std::string& text);

// Returns the albedo of each vertex of `mesh` that a choice names. Throws what surfaceColors() throws.
std::vector<Vec3> readAlbedo(const std::string& choice, const Mesh& mesh);

// Returns the colours of each vertex of `mesh`, which is the mesh of `source` and may have got backs. Without an
// albedo among the options the source's own base colours are the albedo. Throws UsageError and InvalidInput, which
// name what is wrong.
SurfaceColors surfaceColors(const BakeSource& source, const Mesh& mesh, const TransferOptions& options);

}  // namespace penumbra
