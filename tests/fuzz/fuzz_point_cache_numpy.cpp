// Feeds bytes to the readers of NumPy point caches, as an .npz (its checksums stop most changes) or, by their first
// byte, as an .npy, and samples what they accept.
#include <algorithm>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    const std::filesystem::path path = memoryFile("point_cache", data, size), mesh = path.string() + ".obj";
    const std::filesystem::path cache_path = path.string() + (size > 0 && data[0] == 0x93 ? ".npy" : ".npz");
    std::filesystem::rename(path, cache_path);
    std::ofstream(mesh) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    try {
        const PointCache cache = cache_path.extension() == ".npy" ? readPointCache({cache_path, mesh}, {})
                                                                  : readPointCache({cache_path}, {});
        for (std::size_t key = 0; key < std::min<std::size_t>(cache.clips[0].times.size(), 4); ++key)
            samplePositions(cache, 0, cache.clips[0].times[key]);
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
