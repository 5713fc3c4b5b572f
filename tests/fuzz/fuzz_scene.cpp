// Feeds scene.json; see fuzz_visibility_file.cpp.
#include <string>

#include "formats/common/errors.h"
#include "formats/scene/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        (void)penumbra::parseScene(std::string(reinterpret_cast<const char*>(data), size), "scene.json", "/folder");
    } catch (const penumbra::InvalidInput&) {
    }
    return 0;
}
