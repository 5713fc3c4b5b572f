// Any bytes give a picture, InvalidInput or Unsupported.
#include <cstdint>

#include "formats/common/errors.h"
#include "formats/image/environment_map.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        penumbra::decodeImage(std::as_bytes(std::span(data, size)), "fuzz");
        // A light, as lenient as it can be read.
        penumbra::PictureOptions options;
        options.fill = penumbra::Vec3{1, 1, 1};
        options.repair = true;
        const penumbra::RandomBytes bytes = penumbra::bytesOf(std::as_bytes(std::span(data, size)));
        const auto rows = penumbra::openPicture(bytes, "fuzz", options);
        penumbra::makeEnvironmentMap(penumbra::readFilePicture(*rows, "fuzz", options), "", "fuzz");
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    }
    return 0;
}
