#pragma once
// /drawn in visibility and model files: the dense mesh of a character that was baked at some of its points.
#include <optional>

#include "formats/common/drawn_mesh.h"
#include "formats/stage/hdf5_handle.h"

namespace penumbra {

void writeDrawnMesh(hid_t file, const DrawnMesh& drawn);
// Returns what the file has. `mesh` and `skin` are those of the points; slots and joints are theirs too. Throws
// InvalidInput for indices out of range, weights that do not add up to 1 and points that are not where their vertices
// are.
std::optional<DrawnMesh> readDrawnMesh(const Hdf5Reader& in, const Mesh& mesh, const Skin& skin);

}  // namespace penumbra
