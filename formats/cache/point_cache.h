#pragma once
// Reads deforming meshes without a skeleton: cloth, simulations, morph targets. There is one list of faces, and
// positions for every frame of one or more clips, which are read one frame at a time.
//
// The formats are NumPy .npz (positions, faces, rate); NumPy .npy, LightWave .mdd and 3ds Max .pc2 (positions) with a
// mesh from an .obj or .ply file or an .npy of faces; numbered .obj and .ply files; glTF with animated morph targets.
// formats/README.md, "Point caches that bakes read", tells how a sequence is named, and each format's keys, units and
// times.
//
// Several paths make one cache. Each brings its clips, and all must have the same vertices and faces. The mesh is
// that of the first path that has one. An .obj or .ply file is the mesh of another path where that path is an .npy,
// .mdd or .pc2, and is the first file of a sequence otherwise.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// Keys a second where a file does not tell.
constexpr double kCacheFps = 24;

// The caller says with these what a file does not say itself.
struct PointCacheOptions {
    double metres = 1;  // length of one unit of the file, > 0 (metresOfUnit())
    bool z_up = false;  // (x, y, z) of the file is (x, z, -y) here
    // Keys at 0, 1/fps, 2/fps, ... whatever the file says; 0: as the file says, else kCacheFps.
    double fps = 0;
};

// Reads "m", "cm", "mm", "inch" or a number of metres > 0. Throws std::invalid_argument.
double metresOfUnit(const std::string& units);

struct PointCacheClip {
    std::string name;           // unique in the cache
    std::vector<double> times;  // times of the keys in seconds, ascending, at least one
};

struct PointCache {
    // The welded mesh: source vertices that share a place at rest and in every key are one. rest_positions are the
    // rest pose that a file brings, or else the first key of the first clip. Triangles without area at rest are left
    // out.
    Mesh mesh;
    std::vector<PointCacheClip> clips;
    std::vector<std::filesystem::path> files_read;  // for provenance and depfiles
    std::vector<std::string> notes;                 // guesses that the user should know of, a line each
    std::vector<std::uint32_t> source_of_point;     // [V], the first source vertex of each
    // Positions [R] of the source's vertices, model frame, metres. Call readFrame() and samplePositions() instead of
    // these.
    std::function<std::vector<Vec3>(std::size_t clip, std::size_t key)> read_source;
    std::function<std::vector<Vec3>(std::size_t clip, double time)> sample_source;
};

// Returns the positions [V] of a key. Any number of threads may call it. Throws InvalidInput, which names the frame
// (from 0) and the vertex whose position is not finite.
std::vector<Vec3> readFrame(const PointCache& cache, std::size_t clip, std::size_t key);

// Returns the positions [V] at a time: linear between the keys (glTF: as the file says), and constant before the
// first and after the last.
std::vector<Vec3> samplePositions(const PointCache& cache, std::size_t clip, double time);

// Does what sampleFrames() of a rig does (rig_file.h); at `fps` a clip starts at its first key.
FrameList sampleFrames(const PointCache& cache, const std::vector<std::string>& clips, double fps);

}  // namespace penumbra
