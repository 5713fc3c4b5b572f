// Feeds bytes to the reader of motion capture files, and poses what it accepts.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    static const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("penumbra_fuzz_bvh_" + std::to_string(getpid()) + ".bvh");
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), std::streamsize(size));
    try {
        const RigSource source = readBvh(path);
        for (const double time : {0.0, 0.3, 1e9}) localTransforms(source.nodes, &source.clips[0], time);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    }
    return 0;
}
