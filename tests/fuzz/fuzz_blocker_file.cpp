// Feeds penumbra.blockers files; see fuzz_visibility_file.cpp.
#include "formats/common/errors.h"
#include "formats/stage/blocker_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = penumbra::memoryFile("blockers", data, size);
    try {
        (void)penumbra::readBlockers(path);
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    } catch (const penumbra::IoError&) {
    }
    return 0;
}
