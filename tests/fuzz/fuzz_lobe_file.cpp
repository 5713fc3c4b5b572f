// Feeds penumbra.lobes files; see fuzz_visibility_file.cpp.
#include "formats/common/errors.h"
#include "formats/stage/lobe_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = penumbra::memoryFile("lobes", data, size);
    try {
        (void)penumbra::readLobes(path);
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    } catch (const penumbra::IoError&) {
    }
    return 0;
}
