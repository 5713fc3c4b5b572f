// Feeds bytes to what takes over a rig from the process that imported it, and joins the FBX nodes of what it accepts.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/rig/rig_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    try {
        RigSource source = rigFromBytes({reinterpret_cast<const std::byte*>(data), size});
        checkSource(source);
        collapseFbxPivots(source);
    } catch (const InvalidInput&) {
    } catch (const std::out_of_range&) {
    }
    return 0;
}
