#pragma once
// The groups /parts and /fields and the attribute `fade`, in which fields files and composed models hold the fields of
// their parts.
#include "formats/common/part_fields.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

void writePartFields(hid_t file, const PartFields& fields);
// Reads the fields of parts that move with the joints [0, joints). Without joints there is one part, of joint 0. Throws
// InvalidInput.
PartFields readPartFields(const Hdf5Reader& in, std::size_t joints);

}  // namespace penumbra
