#pragma once
// The options of the visibility bake. All defaults stand here, and the documents show these.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/cache/point_cache.h"
#include "formats/common/frame_range.h"
#include "formats/rig/rig_options.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// A colour of every vertex: one for all, or from a table (bake/source/surface_colors.h). Both unset: unknown.
struct ColorChoice {
    std::optional<Vec3> color = {};
    std::optional<std::filesystem::path> table = {};

    bool any() const { return color || table; }
};

// The bake of diffuse transfer in place of visibility.
struct TransferOptions {
    int bounces = 0;                   // 0..kMaxBounces
    ColorChoice albedo, transmission;  // only with bounces
};

struct BakeOptions {
    std::vector<std::string> clips = {};              // names; empty = all clips (none with `poses`)
    double fps = 0;                                   // samples a second, 0..1000; 0 = the clips' own key times
    std::optional<FrameRange> frames = {};            // unset = all frames
    std::optional<std::filesystem::path> poses = {};  // x.poses.h5: these frames, then those of `clips`
    // Each clip is cut into so many contiguous blocks of equal length, 1..10000. A block is a clip of its own.
    int blocks = 1;
    PointCacheOptions cache = {};
    RigOptions rig = {};
    int points = 0;          // bake so many chosen points of the surface (choose_points.h); 0: all
    int order = 5;           // SH bands, 1..kMaxOrder; 5 gives 25 coefficients a vertex
    int rays = 1024;         // directions above the horizon (the set over the sphere has twice as many), 16..2^16
    std::uint64_t seed = 1;  // 1 is the plain set of directions; any other seed turns it
    double bias = 1e-4;   // distance from the surface to the start of a ray, in diagonals of the rest pose, 1e-7..1e-1
    bool ground = false;  // an infinite floor blocks the directions that point down
    std::optional<double> ground_y = {};  // the floor's height in metres; unset = lowest point of the rest pose
    double distance = 0;     // metres at which occluders cease to count (ray_reach.h); 0: they count at any distance
    bool two_sided = false;  // every vertex has a back (Mesh::two_sided)
    std::vector<std::filesystem::path> occluders = {};  // meshes that block rays and get no moments (blockers.h)
    std::optional<std::filesystem::path> inputs = {};   // CSV of numbers that join the pose (input_table.h)
    std::optional<LocalMoments> local = {};             // also bake what the local triangles alone leave visible
    std::optional<TransferOptions> transfer = {};       // unset: bake visibility
    Precision precision = Precision::kFloat32;
};

}  // namespace penumbra
