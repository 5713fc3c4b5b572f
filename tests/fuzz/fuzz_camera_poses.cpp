// Feeds poses.json of cameras; see fuzz_visibility_file.cpp. What can be read can be written and read again.
#include <string>

#include "formats/camera/camera_file.h"
#include "formats/common/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    try {
        const std::string text(reinterpret_cast<const char*>(data), size);
        (void)parseCameraTrack(cameraTrackText(parseCameraTrack(text, "poses.json")), "poses.json");
    } catch (const InvalidInput&) {
    }
    return 0;
}
