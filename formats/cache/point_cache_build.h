#pragma once
// Between the readers of point caches, one a format, and the cache: what one path brings.
#include "formats/cache/point_cache.h"

namespace penumbra {

struct CacheFile {
    std::filesystem::path file;  // for messages
    std::size_t vertex_count = 0;
    std::vector<Vec3d> rest;          // [R] or empty: the first key
    std::vector<Triangle> triangles;  // indices < vertex_count; empty: the path brings no faces
    std::vector<std::string> slots;   // as in Mesh, of source vertices
    std::vector<std::uint16_t> slot_of_vertex;
    std::vector<PointCacheClip> clips;  // empty: a mesh only
    // Positions [R] of a key in the file's own space, and what messages call it ("FILE: frame 3"). For any threads.
    std::function<std::vector<Vec3d>(std::size_t clip, std::size_t key)> read;
    std::function<std::string(std::size_t clip, std::size_t key)> frame_name;
    // Positions [R] at a time between the keys; empty: linear.
    std::function<std::vector<Vec3d>(std::size_t clip, double time)> sample;
    std::vector<std::filesystem::path> files_read;
    std::string note;  // as PointCache::notes, or ""
};

// More keys or triangles than this are refused before memory is taken for them; vertices: kMaxSourceVertices.
constexpr std::size_t kMaxCacheKeys = 10'000'000;
constexpr std::size_t kMaxCacheTriangles = std::size_t(1) << 25;

// The readers.
CacheFile readNpzCache(const std::filesystem::path& path, double fps);
CacheFile readNpyCache(const std::filesystem::path& path, double fps);  // positions [F,V,3], or faces [T,3 or 4]

CacheFile readMddCache(const std::filesystem::path& path, double fps);
CacheFile readPc2Cache(const std::filesystem::path& path, double fps);
CacheFile readSequenceCache(const std::filesystem::path& path, double fps);  // of .obj or .ply
CacheFile readMeshOfCache(const std::filesystem::path& path);                // one .obj or .ply: no clip
CacheFile readGltfCache(const std::filesystem::path& path, double fps);      // morph targets; UsageError with an fps

// Keys at 0, 1/fps, ...
std::vector<double> evenTimes(std::size_t keys, double fps);

}  // namespace penumbra
