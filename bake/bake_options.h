#pragma once
// What the visibility bake needs to know. The defaults here are the documented ones; nothing else holds a default.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/cache/point_cache.h"
#include "formats/common/frame_range.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct BakeOptions {
    std::vector<std::string> clips = {};              // names; empty = all (none with `poses`)
    double fps = 0;                                   // samples a second, 0..1000; 0 = the clips' own key times
    std::optional<FrameRange> frames = {};            // nothing = all
    std::optional<std::filesystem::path> poses = {};  // x.poses.h5: these frames, then those of `clips`
    int blocks = 1;  // contiguous blocks of equal length that every clip is cut into, each a clip of its own, 1..10000
    PointCacheOptions cache = {};
    int order = 5;           // SH bands, 1..kMaxOrder; 5 gives 25 coefficients a vertex
    int rays = 1024;         // directions above the horizon (the set over the sphere has twice as many), 16..2^16
    std::uint64_t seed = 1;  // 1: the plain set of directions; others turn it
    double bias = 1e-4;      // start of a ray above the surface, in diagonals of the rest pose, 1e-7..1e-1
    bool ground = false;     // directions that point down are blocked: an infinite floor
    std::optional<double> ground_y = {};                // its height in metres; nothing = lowest point of the rest pose
    bool two_sided = false;                             // every vertex has a back (Mesh::two_sided)
    std::vector<std::filesystem::path> occluders = {};  // meshes that block rays and get no moments (blockers.h)
    std::optional<std::filesystem::path> inputs = {};   // CSV of numbers that join the pose (input_table.h)
    Precision precision = Precision::kFloat32;
};

// Empty when the options can be used, else one sentence that names the option, its range and the value given.
std::string findProblem(const BakeOptions& options);

}  // namespace penumbra
