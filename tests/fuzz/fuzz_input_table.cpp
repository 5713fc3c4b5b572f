// Feeds CSV of inputs; see fuzz_visibility_file.cpp.
#include "formats/common/errors.h"
#include "formats/stage/input_table.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = penumbra::memoryFile("inputs", data, size);
    try {
        (void)penumbra::readInputTable(path);
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::IoError&) {
    }
    return 0;
}
