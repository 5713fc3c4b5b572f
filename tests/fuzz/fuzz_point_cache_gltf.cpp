// Feeds bytes to the reader of morph targets as a .glb, and samples what it accepts. Start it with sheet_morph.glb.
#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    const std::filesystem::path path = memoryFile("morph", data, size), glb = path.string() + ".glb";
    std::filesystem::rename(path, glb);
    try {
        isPointCache(glb);
        const PointCache cache = readPointCache({glb}, {});
        for (std::size_t clip = 0; clip < cache.clips.size(); ++clip)
            for (const double time : {0.0, 0.3, 1e9}) samplePositions(cache, clip, time);
        sampleFrames(cache, {}, 0);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
