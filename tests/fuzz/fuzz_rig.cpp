// Feeds bytes to the glTF reader as a .glb, and poses what it accepts. Start it with the synthetic rigs as corpus.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    static const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("penumbra_fuzz_rig_" + std::to_string(getpid()) + ".glb");
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), std::streamsize(size));
    try {
        const Rig rig = readRig({path});
        RestShape shape;
        for (int clip = -1; clip < int(rig.clips.size()); ++clip)
            for (const double time : {0.0, 0.3, 1e9}) {
                const RigPose pose = evaluatePose(rig, clip, time);
                skinMorphed(rig.mesh, rig.skin, rig.rest_normals, {pose.bones, pose.weights}, shape);
            }
        sampleFrames(rig, {}, 0);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
