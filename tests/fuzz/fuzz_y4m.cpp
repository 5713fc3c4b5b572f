// Any bytes give the pictures of a video, InvalidInput or Unsupported.
#include <sstream>

#include "formats/common/errors.h"
#include "formats/image/y4m_stream.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
        penumbra::Y4mReader reader(in, "fuzz");
        std::vector<std::uint8_t> planes, rgb;
        while (reader.next(planes)) {
            rgb.resize(3 * std::size_t(reader.header().width) * std::size_t(reader.header().height));
            penumbra::rgbFromPlanes(reader.header(), planes, rgb);
        }
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    }
    return 0;
}
