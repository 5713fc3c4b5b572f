// Feeds bytes to what rewrites Collada files before assimp reads them.
#include <cstddef>
#include <cstdint>

#include "formats/common/errors.h"
#include "formats/rig/assimp/collada_text.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    try {
        prepareCollada({reinterpret_cast<const char*>(data), size}, "fuzz.dae");
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    }
    return 0;
}
