#pragma once
// The parts of a model file that version 2 has not: inputs, and meshes without a skeleton.
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// Whether anything of version 3 is in the model.
bool usesVersion3(const Model& model);
void writeModelInputs(hid_t file, const Model& model);
void writeDeforming(hid_t file, const Model& model);
// After mesh, skin and frames; InvalidInput.
void readModelInputs(const Hdf5Reader& in, Model& model);
void readDeforming(const Hdf5Reader& in, Model& model);

}  // namespace penumbra
