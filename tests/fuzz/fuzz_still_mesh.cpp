// Any bytes give the triangles of a .glb, InvalidInput or Unsupported.
#include <cstdint>

#include "formats/cache/still_mesh.h"
#include "formats/common/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        penumbra::parseStillGlb(std::as_bytes(std::span(data, size)), "fuzz");
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    }
    return 0;
}
