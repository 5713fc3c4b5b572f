// Feeds bytes to the glTF reader as a .glb, and reads the colours of what it accepts.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "bake/source/base_colors.h"
#include "formats/common/errors.h"
#include "formats/source/source_readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    static const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("penumbra_fuzz_colors_" + std::to_string(getpid()) + ".glb");
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), std::streamsize(size));
    try {
        readBaseColors(readRig({path}), "fuzz");
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const UsageError&) {
    } catch (const IoError&) {
    }
    return 0;
}
