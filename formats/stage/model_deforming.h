#pragma once
// Reads and writes the parts of a model file that few models have: inputs, and meshes without a skeleton.
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/model_file.h"

namespace penumbra {

void writeModelInputs(hid_t file, const Model& model);
void writeDeforming(hid_t file, const Model& model);
// Call these after mesh, skin and frames. They throw InvalidInput.
void readModelInputs(const Hdf5Reader& in, Model& model);
void readDeforming(const Hdf5Reader& in, Model& model);

}  // namespace penumbra
