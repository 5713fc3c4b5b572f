// Reads numbered .obj and .ply files as a point cache, and one such file as the mesh of another cache.
#include <algorithm>

#include "formats/cache/mesh_file.h"
#include "formats/cache/numbered_files.h"
#include "formats/cache/point_cache_build.h"
#include "formats/common/errors.h"

namespace penumbra {

CacheFile readMeshOfCache(const std::filesystem::path& path) {
    MeshFile mesh = readMeshFile(path);
    CacheFile cache;
    cache.file = path;
    cache.vertex_count = mesh.positions.size();
    cache.rest = std::move(mesh.positions);
    cache.triangles = std::move(mesh.triangles);
    cache.slots = std::move(mesh.slots);
    cache.slot_of_vertex = std::move(mesh.slot_of_vertex);
    cache.files_read = {path};
    return cache;
}

namespace {
// All frames must have these in common with the first one.
struct Topology {
    std::filesystem::path file;
    std::size_t vertices = 0;
    std::vector<Triangle> triangles;
};

std::vector<Vec3d> readSequenceFrame(const std::filesystem::path& path, const Topology& topology) {
    MeshFile mesh = readMeshFile(path);
    const auto fail = [&](const std::string& what) {
        throw InvalidInput(path.string() + ": " + what + ", unlike " + topology.file.string());
    };
    if (mesh.positions.size() != topology.vertices)
        fail("has " + std::to_string(mesh.positions.size()) + " vertices, not " + std::to_string(topology.vertices));
    if (mesh.triangles.size() != topology.triangles.size())
        fail("has " + std::to_string(mesh.triangles.size()) + " triangles, not " +
             std::to_string(topology.triangles.size()));
    const auto differs = std::mismatch(mesh.triangles.begin(), mesh.triangles.end(), topology.triangles.begin());
    if (differs.first != mesh.triangles.end())
        fail("its triangle " + std::to_string(differs.first - mesh.triangles.begin()) + " has other vertices");
    return std::move(mesh.positions);
}

}  // namespace

CacheFile readSequenceCache(const std::filesystem::path& path, double fps) {
    const NumberedFiles sequence = findNumberedFiles(path, {".obj", ".ply"});
    if (sequence.files.size() > kMaxCacheKeys) throw Unsupported(path.string() + ": has too many frames");
    CacheFile cache = readMeshOfCache(sequence.files[0]);
    cache.rest.clear();  // the first frame is the rest
    cache.files_read = sequence.files;
    if (sequence.step > 1)
        cache.note = path.string() + ": numbers in steps of " + std::to_string(sequence.step) +
                     "; each file is one frame, and frames a second count files";
    cache.clips.push_back({sequence.name, evenTimes(sequence.files.size(), fps > 0 ? fps : kCacheFps)});
    cache.read = [files = sequence.files, topology = Topology{cache.file, cache.vertex_count, cache.triangles}](
                     std::size_t, std::size_t key) { return readSequenceFrame(files[key], topology); };
    cache.frame_name = [files = sequence.files](std::size_t, std::size_t key) { return files[key].string(); };
    return cache;
}

}  // namespace penumbra
