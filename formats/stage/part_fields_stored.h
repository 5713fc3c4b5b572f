#pragma once
// The groups /parts and /fields and the attribute `fade`, in which fields files and composed models hold the fields of
// their parts.
#include "formats/common/part_fields.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

void writePartFields(hid_t file, const PartFields& fields);
// Joints to which parts may be attached: the file's own joints [0, own), in models also the `inputs` joints after them.
// With may_stand, a part may also stand still (kStillJoint). Parts are sorted by joint.
struct PartJoints {
    std::size_t own = 1, inputs = 0;
    bool may_stand = false;
};
// Throws InvalidInput.
PartFields readPartFields(const Hdf5Reader& in, const PartJoints& joints);

}  // namespace penumbra
