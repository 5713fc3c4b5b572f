#pragma once
// Reads and writes what version 2 of a model file does not know: inputs, and meshes without a skeleton.
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// Tells whether the model has anything that is new in version 3.
bool usesVersion3(const Model& model);
void writeModelInputs(hid_t file, const Model& model);
void writeDeforming(hid_t file, const Model& model);
// Call these after mesh, skin and frames. They throw InvalidInput.
void readModelInputs(const Hdf5Reader& in, Model& model);
void readDeforming(const Hdf5Reader& in, Model& model);

}  // namespace penumbra
