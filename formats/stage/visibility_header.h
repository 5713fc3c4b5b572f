#pragma once
// What all frames of x.vis.h5 share. Included by formats/visibility_*.cpp only.
#include "formats/stage/stage_parts.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

constexpr const char* kCoefficients = "/visibility/coefficients";

void writeVisibilityHeader(hid_t file, const VisibilityHeader& header);
// Without what stands at /frames/pose.
VisibilityHeader readVisibilityHeader(const Hdf5Reader& in);
// InvalidInput, which starts with `name`, unless the length of /frames/pose goes with edges and inputs.
void checkPose(const std::string& name, const VisibilityHeader& header);

}  // namespace penumbra
