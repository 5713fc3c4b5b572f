#pragma once
// The part of a point cache that one path brings. The readers, one for each format, return it.
#include "formats/cache/point_cache.h"

namespace penumbra {

struct CacheFile {
    std::filesystem::path file;  // for messages
    std::size_t vertex_count = 0;
    std::vector<Vec3d> rest;          // [R]; empty: the first key is the rest pose
    std::vector<Triangle> triangles;  // indices < vertex_count; empty: the path brings no faces
    std::vector<std::string> slots;   // slots of the source vertices, see Mesh
    std::vector<std::uint16_t> slot_of_vertex;
    std::vector<PointCacheClip> clips;  // empty: a mesh only
    // Returns the positions [R] of a key in the file's own space. frame_name is what messages call the key ("FILE:
    // frame 3"). Any number of threads may call these.
    std::function<std::vector<Vec3d>(std::size_t clip, std::size_t key)> read;
    std::function<std::string(std::size_t clip, std::size_t key)> frame_name;
    // Returns the positions [R] at a time between the keys; empty: linear interpolation.
    std::function<std::vector<Vec3d>(std::size_t clip, double time)> sample;
    std::vector<std::filesystem::path> files_read;
    std::string note;  // for PointCache::notes; "": none
};

// More keys or triangles than these are refused before memory is taken for them. kMaxSourceVertices bounds the
// vertices.
constexpr std::size_t kMaxCacheKeys = 10'000'000;
constexpr std::size_t kMaxCacheTriangles = std::size_t(1) << 25;

// One reader for each format.
CacheFile readNpzCache(const std::filesystem::path& path, double fps);
CacheFile readNpyCache(const std::filesystem::path& path, double fps);  // positions [F,V,3], or faces [T,3 or 4]

CacheFile readMddCache(const std::filesystem::path& path, double fps);
CacheFile readPc2Cache(const std::filesystem::path& path, double fps);
CacheFile readSequenceCache(const std::filesystem::path& path, double fps);  // numbered .obj or .ply files
CacheFile readMeshOfCache(const std::filesystem::path& path);                // one .obj or .ply: no clip
// morph targets; throws UsageError when an fps is given
CacheFile readGltfCache(const std::filesystem::path& path, double fps);

// Makes one cache of what the paths bring, in their order. formats/source/source_readers.h reads them.
PointCache joinCache(const std::vector<std::filesystem::path>& paths, std::vector<CacheFile> files,
                     const PointCacheOptions& options);

// Returns times of keys at 0, 1/fps, ...
std::vector<double> evenTimes(std::size_t keys, double fps);

}  // namespace penumbra
