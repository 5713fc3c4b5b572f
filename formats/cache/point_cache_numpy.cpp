// Reads point caches of NumPy: x.npz (savez, savez_compressed) and x.npy (save).
#include <algorithm>
#include <cmath>

#include "formats/cache/numpy_array.h"
#include "formats/cache/point_cache_build.h"
#include "formats/cache/zip_archive.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {
// Tells what quantised numbers stand for: position = offset + step x number, by coordinate. Without quantisation
// numbers stay as they are.
struct Scaling {
    std::array<double, 3> offset{0, 0, 0}, step{1, 1, 1};
};
}  // namespace

[[noreturn]] static void fail(const NumpyArray& array, const std::string& problem) {
    throw InvalidInput(array.what + ": " + problem);
}

namespace {

std::optional<NumpyArray> findArray(const ZipArchive& zip, const std::string& key) {
    std::optional<RandomBytes> bytes = openMember(zip, key + ".npy");
    if (!bytes) return std::nullopt;
    return openNumpy(*bytes, zip.file + ": '" + key + "'");
}

void checkPositions(const NumpyArray& array) {
    const auto& shape = array.shape;
    if (shape.size() != 3 || shape[2] != 3) fail(array, describe(array) + " is not [frames, vertices, 3]");
    if (shape[0] == 0) fail(array, "has no frames");
    if (shape[1] == 0) fail(array, "has no vertices");
    if (shape[0] > kMaxCacheKeys) throw Unsupported(array.what + ": has too many frames");
    if (shape[1] > kMaxSourceVertices) throw Unsupported(array.what + ": has too many vertices");
}

std::vector<Vec3d> readPositions(const NumpyArray& array, const Scaling& scaling, std::uint64_t first,
                                 std::size_t vertices) {
    const std::vector<double> numbers = readNumbers(array, first, 3 * vertices);
    std::vector<Vec3d> positions(vertices);
    for (std::size_t i = 0; i < numbers.size(); ++i)
        positions[i / 3][int(i % 3)] = scaling.offset[i % 3] + numbers[i] * scaling.step[i % 3];
    return positions;
}

// Reads rows of three or four vertex numbers. A quad is cut from its first corner to its third.
std::vector<Triangle> readFaces(const NumpyArray& array, std::uint64_t vertices) {
    const auto& shape = array.shape;
    if (array.kind == 'f' || shape.size() != 2 || (shape[1] != 3 && shape[1] != 4))
        fail(array, describe(array) + " is not integers [faces, 3 or 4]");
    if (shape[0] > kMaxCacheTriangles / 2) throw Unsupported(array.what + ": has too many faces");
    const std::size_t corners = std::size_t(shape[1]);
    const std::vector<double> numbers = readNumbers(array, 0, std::size_t(array.count()));
    for (std::size_t i = 0; i < numbers.size(); ++i)
        if (!(numbers[i] >= 0 && numbers[i] < double(vertices)))
            fail(array, "face " + std::to_string(i / corners) + " names vertex " +
                            std::to_string(std::int64_t(numbers[i])) + " of " + std::to_string(vertices));
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < numbers.size(); i += corners)
        for (std::size_t k = 2; k < corners; ++k)
            triangles.push_back(
                {std::uint32_t(numbers[i]), std::uint32_t(numbers[i + k - 1]), std::uint32_t(numbers[i + k])});
    return triangles;
}

// Reads one finite number, or three where `most` allows it.
std::vector<double> readScalars(const NumpyArray& array, std::size_t most) {
    const std::uint64_t count = array.count();
    if (array.shape.size() > 1 || (count != 1 && count != most))
        fail(array, describe(array) + (most == 1 ? " is not one number" : " is not one number or three"));
    const std::vector<double> values = readNumbers(array, 0, std::size_t(count));
    for (const double v : values)
        if (!std::isfinite(v)) fail(array, "is not finite");
    return values;
}

void setEach(const std::vector<double>& values, std::array<double, 3>& out) {
    for (std::size_t i = 0; i < 3; ++i) out[i] = values[values.size() == 1 ? 0 : i];
}

Scaling readScaling(const ZipArchive& zip) {
    const std::optional<NumpyArray> offset = findArray(zip, "q_lo"), step = findArray(zip, "q_step");
    if (!offset || !step)
        throw InvalidInput(zip.file + ": has 'verts_q' but no '" + (offset ? "q_step" : "q_lo") + "'");
    Scaling scaling;
    setEach(readScalars(*offset, 3), scaling.offset);
    setEach(readScalars(*step, 3), scaling.step);
    return scaling;
}

std::vector<double> readTimes(const NumpyArray& array, std::size_t keys) {
    if (array.shape.size() != 1 || array.shape[0] != keys)
        fail(array, describe(array) + " is not one time for each of " + std::to_string(keys) + " frames");
    std::vector<double> times = readNumbers(array, 0, keys);
    for (std::size_t i = 0; i < keys; ++i)
        if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
            fail(array, "times are not finite and ascending at frame " + std::to_string(i));
    return times;
}

std::vector<double> keyTimes(const ZipArchive& zip, std::size_t keys, double fps) {
    if (fps > 0) return evenTimes(keys, fps);
    if (const std::optional<NumpyArray> times = findArray(zip, "times")) return readTimes(*times, keys);
    const std::optional<NumpyArray> rate = findArray(zip, "fps");
    if (!rate) return evenTimes(keys, kCacheFps);
    const double value = readScalars(*rate, 1)[0];
    if (!(value > 0)) fail(*rate, "is not above 0");
    return evenTimes(keys, value);
}

void setFrames(const NumpyArray& positions, const Scaling& scaling, std::vector<double> times, CacheFile& cache) {
    cache.vertex_count = std::size_t(positions.shape[1]);
    cache.clips.push_back({cache.file.stem().string(), std::move(times)});
    cache.read = [positions, scaling, vertices = cache.vertex_count](std::size_t, std::size_t key) {
        return readPositions(positions, scaling, 3 * std::uint64_t(key) * vertices, vertices);
    };
    cache.frame_name = [what = positions.what](std::size_t, std::size_t key) {
        return what + ": frame " + std::to_string(key);
    };
}

}  // namespace

CacheFile readNpzCache(const std::filesystem::path& path, double fps) {
    const ZipArchive zip = openZip(path);
    const std::optional<NumpyArray> plain = findArray(zip, "verts"), quantised = findArray(zip, "verts_q");
    if (plain && quantised) throw InvalidInput(zip.file + ": has both 'verts' and 'verts_q'");
    if (!plain && !quantised) throw InvalidInput(zip.file + ": has neither 'verts' nor 'verts_q'");
    const NumpyArray& positions = plain ? *plain : *quantised;
    checkPositions(positions);
    if (quantised && quantised->kind != 'u') fail(*quantised, describe(*quantised) + " is not of unsigned integers");
    if (plain && plain->kind != 'f') fail(*plain, describe(*plain) + " is not of floats");
    CacheFile cache;
    cache.file = path;
    cache.files_read = {path};
    setFrames(positions, quantised ? readScaling(zip) : Scaling{}, keyTimes(zip, std::size_t(positions.shape[0]), fps),
              cache);
    if (const std::optional<NumpyArray> faces = findArray(zip, "faces"))
        cache.triangles = readFaces(*faces, cache.vertex_count);
    if (const std::optional<NumpyArray> rest = findArray(zip, "rest")) {
        if (rest->kind != 'f' || rest->shape != std::vector<std::uint64_t>{cache.vertex_count, 3})
            fail(*rest, describe(*rest) + " is not floats [" + std::to_string(cache.vertex_count) + ",3]");
        cache.rest = readPositions(*rest, {}, 0, cache.vertex_count);
    }
    return cache;
}

CacheFile readNpyCache(const std::filesystem::path& path, double fps) {
    const NumpyArray array = openNumpy(openBytes(path), path.string());
    CacheFile cache;
    cache.file = path;
    cache.files_read = {path};
    if (array.kind != 'f') {
        cache.triangles = readFaces(array, kMaxSourceVertices);
        for (const Triangle& t : cache.triangles)
            for (const std::uint32_t v : t) cache.vertex_count = std::max(cache.vertex_count, std::size_t(v) + 1);
        return cache;
    }
    checkPositions(array);
    setFrames(array, {}, evenTimes(std::size_t(array.shape[0]), fps > 0 ? fps : kCacheFps), cache);
    return cache;
}

}  // namespace penumbra
