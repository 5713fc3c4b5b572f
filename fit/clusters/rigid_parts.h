#pragma once
// Finds the near-rigid parts of a deforming mesh: triangles that turn alike and lie together (James and Twigg 2005).
#include <cstdint>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// A deforming mesh. Ts counts front triangles, Vs front vertices, F frames.
struct DeformingFrames {
    std::span<const Triangle> triangles;       // [Ts] triangles of the fronts
    std::span<const Vec3> rest;                // [Vs] rest positions
    std::span<const Vec3> positions;           // [F, Vs]
    std::span<const std::size_t> frames = {};  // the frames that count

    std::span<const Vec3> positionsOf(std::size_t f) const { return positions.subspan(f * rest.size(), rest.size()); }
};

struct RigidParts {
    std::size_t count = 0;
    std::vector<std::uint16_t> part_of_vertex;    // [Vs]; every part has at least one vertex
    std::vector<std::uint16_t> part_of_triangle;  // [Ts]
};

// Rotations are one motion when they differ by at most this much: the root mean square over the frames, in radians.
constexpr double kPartBandwidth = 0.15;
// When `count` is 0, a mesh that bends everywhere is cut into parts of at most this many vertices, but not into more
// parts than this. More parts describe the shape better and cost time and bytes.
constexpr std::size_t kAutoPartVertices = 80, kMaxAutoParts = 64;

// Finds the parts. `count` is the number asked for; 0 lets the function choose. It works in steps.
//
// 1. Mean-shift (mean_shift.h) groups the triangles by their sequences of rotations. A rotation is that of the
//    deformation gradient of edges and normal. At most 32 of the frames, evenly spread, take part, and PCA reduces the
//    sequences to at most 16 dimensions. In a large mesh 2000 triangles, evenly spread, find the modes; each other
//    triangle takes the mode of the nearest of them.
// 2. Connected triangles of one mode are a part. Parts of fewer than Ts/200 triangles join the neighbour that moves
//    most like them.
// 3. When there are too many parts, two neighbours are joined, again and again: those whose union adds least to the sum
//    of squared distances from the mean motion (Ward).
// 4. When there are too few, the part with the largest such sum is cut at the median along its longest axis. With
//    `count` 0, steps 3 and 4 keep to the limits above, and a part is cut only if its halves along one of its two
//    longest axes turn differently, by a quarter of the bandwidth or more.
// 5. A vertex goes with the part that has most of the area around it.
//
// The result is the same for any number of threads.
RigidParts findRigidParts(const DeformingFrames& mesh, std::size_t count, int threads);

}  // namespace penumbra
