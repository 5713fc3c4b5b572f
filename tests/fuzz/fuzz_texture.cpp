// Any bytes give a texture's picture, InvalidInput or Unsupported.
#include <cstdint>

#include "formats/common/errors.h"
#include "formats/image/texture_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        penumbra::decodeTexture(std::as_bytes(std::span(data, size)), "fuzz");
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    }
    return 0;
}
