// Reads point caches without a mesh, which have positions as f32 [keys, vertices, 3]: LightWave's .mdd (big endian)
// and 3ds Max's .pc2 (little endian).
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "formats/cache/point_cache_build.h"
#include "formats/common/errors.h"
#include "formats/common/random_bytes.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {
struct BinaryCache {
    std::filesystem::path path;
    RandomBytes bytes;
    bool swapped = false;
    std::size_t keys = 0, vertices = 0;
    std::uint64_t positions = 0;  // where the positions start

    [[noreturn]] void fail(const std::string& problem) const { throw InvalidInput(path.string() + ": " + problem); }
};

BinaryCache openCache(const std::filesystem::path& path, std::endian order, std::size_t header_size) {
    BinaryCache cache{path, openBytes(path), order != std::endian::native, 0, 0, 0};
    if (cache.bytes.size < header_size) cache.fail("its header is cut short");
    return cache;
}

// Reads numbers of four bytes.
template <class T>
std::vector<T> readWords(const BinaryCache& cache, std::uint64_t offset, std::size_t count) {
    static_assert(sizeof(T) == 4);
    std::vector<std::byte> bytes = readBytes(cache.bytes, offset, 4 * count);
    if (cache.swapped)
        for (std::size_t at = 0; at < bytes.size(); at += 4)
            std::reverse(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + 4));
    std::vector<T> out(count);
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
}

// Checks and stores the numbers of keys and vertices. Between the header and the positions stand `bytes_a_key` for
// each key.
void setCounts(BinaryCache& cache, std::int32_t keys, std::int32_t vertices, std::uint64_t header_size,
               std::uint64_t bytes_a_key) {
    if (keys <= 0) cache.fail("says that it has " + std::to_string(keys) + " frames");
    if (vertices <= 0) cache.fail("says that it has " + std::to_string(vertices) + " vertices");
    if (std::size_t(keys) > kMaxCacheKeys) throw Unsupported(cache.path.string() + ": has too many frames");
    if (std::size_t(vertices) > kMaxSourceVertices) throw Unsupported(cache.path.string() + ": has too many vertices");
    cache.keys = std::size_t(keys);
    cache.vertices = std::size_t(vertices);
    cache.positions = header_size + bytes_a_key * cache.keys;
    const std::uint64_t size = cache.positions + 12 * std::uint64_t(cache.keys) * cache.vertices;
    if (cache.bytes.size != size)
        cache.fail("has " + std::to_string(cache.bytes.size) + " bytes, and " + std::to_string(keys) + " frames of " +
                   std::to_string(vertices) + " vertices take " + std::to_string(size));
}

std::vector<Vec3d> readPositions(const BinaryCache& cache, std::size_t key) {
    const std::vector<float> numbers =
        readWords<float>(cache, cache.positions + 12 * std::uint64_t(key) * cache.vertices, 3 * cache.vertices);
    std::vector<Vec3d> positions;
    positions.reserve(cache.vertices);
    for (std::size_t i = 0; i < numbers.size(); i += 3)
        positions.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
    return positions;
}

CacheFile cacheOf(const BinaryCache& binary, std::vector<double> times) {
    CacheFile cache;
    cache.file = binary.path;
    cache.vertex_count = binary.vertices;
    cache.clips.push_back({binary.path.stem().string(), std::move(times)});
    cache.read = [binary](std::size_t, std::size_t key) { return readPositions(binary, key); };
    cache.frame_name = [name = binary.path.string()](std::size_t, std::size_t key) {
        return name + ": frame " + std::to_string(key);
    };
    cache.files_read = {binary.path};
    return cache;
}

}  // namespace

// Reads i32 frames, i32 vertices, f32 seconds [frames], positions.
CacheFile readMddCache(const std::filesystem::path& path, double fps) {
    constexpr std::size_t header_size = 8;
    BinaryCache cache = openCache(path, std::endian::big, header_size);
    const std::vector<std::int32_t> header = readWords<std::int32_t>(cache, 0, 2);
    setCounts(cache, header[0], header[1], header_size, 4);
    if (fps > 0) return cacheOf(cache, evenTimes(cache.keys, fps));
    const std::vector<float> seconds = readWords<float>(cache, header_size, cache.keys);
    for (std::size_t i = 0; i < seconds.size(); ++i)
        if (!std::isfinite(seconds[i]) || (i > 0 && !(seconds[i] > seconds[i - 1])))
            cache.fail("its times are not finite and ascending at frame " + std::to_string(i) +
                       "; frames a second that are given replace them");
    return cacheOf(cache, {seconds.begin(), seconds.end()});
}

// Reads "POINTCACHE2\0", i32 version = 1, i32 vertices, f32 start and f32 step in frames of the scene, i32 keys,
// positions.
CacheFile readPc2Cache(const std::filesystem::path& path, double fps) {
    constexpr std::size_t header_size = 32;
    BinaryCache cache = openCache(path, std::endian::little, header_size);
    const std::vector<std::byte> magic = readBytes(cache.bytes, 0, 12);
    if (std::memcmp(magic.data(), "POINTCACHE2", 12) != 0) cache.fail("is not a PC2 cache");
    const std::vector<std::int32_t> header = readWords<std::int32_t>(cache, 12, 5);
    if (header[0] != 1) throw Unsupported(path.string() + ": PC2 version " + std::to_string(header[0]));
    setCounts(cache, header[4], header[1], header_size, 0);
    const std::vector<float> range = readWords<float>(cache, 20, 2);
    const double start = range[0], step = range[1], rate = fps > 0 ? fps : kCacheFps;
    if (!std::isfinite(start)) cache.fail("its start frame is not finite");
    if (!std::isfinite(step) || !(step > 0)) cache.fail("its sample rate is not above 0");
    std::vector<double> times;
    for (std::size_t i = 0; i < cache.keys; ++i) {
        times.push_back((start + double(i) * step) / rate);
        if (i > 0 && !(times[i] > times[i - 1])) cache.fail("its sample rate is too small for its start frame");
    }
    return cacheOf(cache, std::move(times));
}

}  // namespace penumbra
