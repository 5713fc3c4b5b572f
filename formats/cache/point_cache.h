#pragma once
// Deforming meshes without a skeleton: cloth, simulations, morph targets. One list of faces, and positions for every
// frame of one or more clips, read one frame at a time.
//
// Read here: NumPy .npz (positions, faces, rate); NumPy .npy, LightWave .mdd and 3ds Max .pc2 (positions) with a mesh,
// an .obj or .ply file or an .npy of faces; numbered .obj and .ply files; glTF with animated morph targets.
// formats/README.md, "Point caches that bakes read", has how a sequence is named, and keys, units and times of each.
//
// Several paths are one cache: each brings its clips; all must have the same vertices and faces. The mesh is that of
// the first path that has one. An .obj or .ply file is the mesh of another path where that is an .npy, .mdd or .pc2,
// and else the first file of a sequence.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// Keys a second where a file does not say.
constexpr double kCacheFps = 24;

// Command line: --units, --up, --cache-fps.
struct PointCacheOptions {
    double metres = 1;  // of one unit of the file, > 0 (--units: metresOfUnit())
    bool z_up = false;  // --up z: (x, y, z) of the file is (x, z, -y) here; --up y: as it is
    double fps = 0;  // --cache-fps: keys at 0, 1/fps, 2/fps, ... whatever the file says; 0: by the file, else kCacheFps
};

// Empty when the options can be used, else one sentence that names the option, its range and the value given.
std::string findProblem(const PointCacheOptions& options);
// "m", "cm", "mm", "inch" or a number of metres, > 0. UsageError "--units: ...".
double metresOfUnit(const std::string& units);
// "y" or "z": true for z. UsageError "--up: ...".
bool upIsZ(const std::string& up);

struct PointCacheClip {
    std::string name;           // unique in the cache
    std::vector<double> times;  // of the keys, seconds, ascending, at least one
};

struct PointCache {
    // Welded: source vertices that are at the same place at rest and in every key are one. rest_positions: the rest
    // that a file brings, else the first key of the first clip. Triangles without area at rest are left out.
    Mesh mesh;
    std::vector<PointCacheClip> clips;
    std::vector<std::filesystem::path> files_read;  // for provenance and depfiles
    std::vector<std::string> notes;                 // what was guessed and the user should know, a line each
    std::vector<std::uint32_t> source_of_point;     // [V], the first source vertex of each
    // Positions [R] of the source's vertices, model frame, metres. Call readFrame() and samplePositions() instead.
    std::function<std::vector<Vec3>(std::size_t clip, std::size_t key)> read_source;
    std::function<std::vector<Vec3>(std::size_t clip, double time)> sample_source;
};

// Is the path one that readPointCache() reads: by its extension, as a folder or pattern of a sequence, or as a glTF
// with animated morph targets and no skin in use? (A path that cannot be read is what its name says.)
bool isPointCache(const std::filesystem::path& path);

// Checks everything but the frames' numbers, which are checked when they are read. UsageError (findProblem()), IoError,
// InvalidInput that names file, field and frame, Unsupported.
PointCache readPointCache(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options);

// Positions [V] of a key. Any number of threads may call it. InvalidInput names the frame (from 0) and the vertex that
// is not at a finite place.
std::vector<Vec3> readFrame(const PointCache& cache, std::size_t clip, std::size_t key);

// Positions [V] at a time: between the keys linear (glTF: as the file says), before the first and after the last as
// there.
std::vector<Vec3> samplePositions(const PointCache& cache, std::size_t clip, double time);

// As sampleFrames() of a rig (rig_file.h); at `fps` a clip starts at its first key.
FrameList sampleFrames(const PointCache& cache, const std::vector<std::string>& clips, double fps);

}  // namespace penumbra
