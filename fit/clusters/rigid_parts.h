#pragma once
// Near-rigid parts of a deforming mesh (James and Twigg 2005): triangles that turn alike and lie together.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct DeformingFrames {
    std::span<const Triangle> triangles;       // of the fronts
    std::span<const Vec3> rest;                // [Vs]
    std::span<const Vec3> positions;           // [F, Vs]
    std::span<const std::size_t> frames = {};  // which of the F count

    std::span<const Vec3> positionsOf(std::size_t f) const { return positions.subspan(f * rest.size(), rest.size()); }
};

struct RigidParts {
    std::size_t count = 0;
    std::vector<std::uint16_t> part_of_vertex;    // [Vs]; every part has a vertex
    std::vector<std::uint16_t> part_of_triangle;  // [Ts]
};

// Rotations that differ by this much, root mean square over the frames in radians, are one motion.
constexpr double kPartBandwidth = 0.15;
// What `count` 0 makes of a mesh that bends everywhere: parts of at most this many vertices, but not more parts than
// this. More parts see the shape better and cost time and bytes.
constexpr std::size_t kAutoPartVertices = 80, kMostAutoParts = 64;

// 1. Mean-shift (mean_shift.h) over the triangles' sequences of rotations: the rotation of the deformation gradient of
// edges and normal, in at most 32 of the frames, evenly spread, brought to at most 16 dimensions by PCA. Of a large
// mesh 2000 triangles, evenly spread, find the modes; the others follow the nearest of them.
// 2. Connected triangles of one mode are a part. Parts of fewer than Ts/200 triangles join the neighbour that moves
// most like them. 3. Too many: the neighbours whose union raises the sum of squared distances from the mean motion
// least (Ward) become one, again and again. 4. Too few: the part with the largest such sum is cut at the median along
// its longest axis. `count` 0: steps 3 and 4 keep to the limits above, and a part is only cut if its halves along one
// of its two longest axes turn differently, by a quarter of the bandwidth or more. 5. A vertex goes with the part that
// has most of the area around it. The same result for any number of threads.
RigidParts findRigidParts(const DeformingFrames& mesh, std::size_t count, int threads);

}  // namespace penumbra
