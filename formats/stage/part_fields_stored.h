#pragma once
// The groups /parts and /fields and the attribute `fade`, in which fields files and composed models hold the fields of
// their parts.
#include "formats/common/part_fields.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

void writePartFields(hid_t file, const PartFields& fields);
// What the parts of a file may move with: the joints [0, own), by ascending joints, and in models also the `inputs`
// joints after them; or they stand still (kStillJoint).
struct PartJoints {
    std::size_t own = 1, inputs = 0;
    bool may_stand = false;
};
// Throws InvalidInput.
PartFields readPartFields(const Hdf5Reader& in, const PartJoints& joints);

}  // namespace penumbra
