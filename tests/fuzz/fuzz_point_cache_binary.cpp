// Feeds bytes to the readers of .mdd and .pc2 caches, .obj and .ply meshes.
#include <algorithm>
#include <string_view>

#include "formats/cache/mesh_file.h"
#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/fuzz/memory_file.h"

namespace {

void readCache(const std::uint8_t* data, std::size_t size, const char* extension) {
    using namespace penumbra;
    const std::filesystem::path path = memoryFile("positions", data, size), cache_path = path.string() + extension;
    const std::filesystem::path mesh = path.string() + ".obj";
    std::filesystem::rename(path, cache_path);
    std::ofstream(mesh) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const PointCache cache = readPointCache({cache_path, mesh}, {});
    for (std::size_t key = 0; key < std::min<std::size_t>(cache.clips[0].times.size(), 4); ++key)
        readFrame(cache, 0, key);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    try {
        if (text.starts_with("POINTCACHE2"))
            readCache(data, size, ".pc2");
        else if (text.starts_with(std::string_view("\0", 1)))
            readCache(data, size, ".mdd");
        else if (text.starts_with("ply"))
            parsePly(text, "fuzz");
        else
            parseObj(text, "fuzz");
    } catch (const InvalidInput&) {
    } catch (const Unsupported&) {
    } catch (const IoError&) {
    }
    return 0;
}
