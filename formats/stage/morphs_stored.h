#pragma once
// Reads and writes /mesh/morphs, the morph targets of a mesh. Moves are stored as f32, as rest positions are: bake, fit
// and run time shall add the same numbers and get the same surface.
#include "formats/common/morph_targets.h"
#include "formats/stage/hdf5_handle.h"

namespace penumbra {

// Writes nothing where there are no targets. `mesh` is the group of the mesh.
void writeMorphs(hid_t file, const MorphTargets& morphs, const std::string& mesh = "/mesh");
// Returns no targets where the file has none. Throws InvalidInput.
MorphTargets readMorphs(const Hdf5Reader& in, std::size_t vertices, const std::string& mesh = "/mesh");
// Checks that the last names of `inputs` (/inputs/names) are those of the targets, whose weights they are.
void checkMorphInputs(const Hdf5Reader& in, const MorphTargets& morphs, const std::vector<std::string>& inputs);

}  // namespace penumbra
