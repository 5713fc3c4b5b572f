// Feeds x.poses.json; see fuzz_visibility_file.cpp.
#include <string>

#include "formats/common/errors.h"
#include "formats/scene/bone_poses.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        (void)penumbra::parseBonePoses(std::string(reinterpret_cast<const char*>(data), size), "x.poses.json");
    } catch (const penumbra::InvalidInput&) {
    }
    return 0;
}
