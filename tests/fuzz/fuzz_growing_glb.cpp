// Any bytes give a file that can be added to, InvalidInput, IoError (a buffer in another file) or Unsupported.
#include <array>

#include "formats/common/errors.h"
#include "formats/rig/growing_glb.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        penumbra::GrowingGlb glb = penumbra::openGrowingGlb(penumbra::memoryFile("growing_glb", data, size));
        const std::array<float, 3> numbers{1, 2, 3};
        penumbra::addAccessor(glb, numbers, 3, penumbra::AccessorUse::kVertices);
        penumbra::bytesOf(glb);
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::IoError&) {
    } catch (const penumbra::Unsupported&) {
    }
    return 0;
}
