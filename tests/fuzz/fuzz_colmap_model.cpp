// Feeds the text model of COLMAP, cameras.txt and images.txt with a 0 byte between; see fuzz_visibility_file.cpp.
#include <string>

#include "formats/camera/colmap_model.h"
#include "formats/common/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    const std::string text(reinterpret_cast<const char*>(data), size);
    const std::size_t middle = std::min(text.find('\0'), text.size());
    try {
        (void)parseColmapModel(text.substr(0, middle), text.substr(std::min(middle + 1, text.size())), "model");
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    }
    return 0;
}
