// Feeds bytes to the reader of NumPy point caches as an .npz, and reads the frames of what it accepts.
#include "formats/errors.h"
#include "formats/point_cache.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    const std::filesystem::path path = memoryFile("point_cache", data, size), npz = path.string() + ".npz";
    std::filesystem::rename(path, npz);
    try {
        const PointCache cache = readPointCache({npz}, {});
        for (std::size_t key = 0; key < std::min<std::size_t>(cache.clips[0].times.size(), 4); ++key)
            samplePositions(cache, 0, cache.clips[0].times[key]);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
