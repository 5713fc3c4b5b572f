#pragma once
// Reads and writes the errors of a model by clip, /errors.
#include <vector>

#include "formats/stage/hdf5_handle.h"
#include "formats/stage/model_file.h"

namespace penumbra {

void writeClipErrors(hid_t file, const std::vector<ClipError>& errors);
std::vector<ClipError> readClipErrors(const Hdf5Reader& in);  // throws InvalidInput

}  // namespace penumbra
