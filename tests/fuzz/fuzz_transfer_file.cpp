// Feeds penumbra.transfer files; see fuzz_visibility_file.cpp.
#include "formats/common/errors.h"
#include "formats/stage/transfer_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = penumbra::memoryFile("transfer", data, size);
    try {
        (void)penumbra::readTransfer(path);
    } catch (const penumbra::InvalidInput&) {
    } catch (const penumbra::Unsupported&) {
    } catch (const penumbra::IoError&) {
    }
    return 0;
}
