#pragma once
// Reads and writes what all frames of x.vis.h5 share. Only formats/stage/visibility_*.cpp include this.
#include "formats/stage/stage_parts.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

constexpr const char* kCoefficients = "/visibility/coefficients";
constexpr const char* kLocal = "/visibility/local";
constexpr const char* kIndirect = "/visibility/indirect";
constexpr const char* kHitShares = "/visibility/hit_shares";

void writeVisibilityHeader(hid_t file, const VisibilityHeader& header);
// Reads everything except what stands at /frames/pose.
VisibilityHeader readVisibilityHeader(const Hdf5Reader& in);
// Writes the attributes of /visibility/local, which exists already.
void writeLocalAttributes(hid_t file, const LocalMoments& local);
// Throws InvalidInput, which starts with `name`, unless the length of /frames/pose fits edges and inputs.
void checkPose(const std::string& name, const VisibilityHeader& header);

}  // namespace penumbra
