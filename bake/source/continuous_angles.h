#pragma once
// Computes dihedral angles of a clip that go on through +-pi. From the first sampled frame of the clip on, each
// frame's angles are moved by whole turns to within pi of the frame before. A shard computes the same as the whole
// bake, because it also starts at the first frame of the clip.
#include <cstdint>
#include <span>
#include <vector>

#include "bake/source/bake_source.h"
#include "sh/dihedral_angles.h"

namespace penumbra {

// The whole turns of one edge. Only edges that are folded beyond a half turn have any.
struct EdgeTurns {
    std::uint32_t edge = 0;
    std::int32_t turns = 0;
};

// Returns for each of the frames `wanted` (ascending indices into `all`, which lists clips of `source`) the edges
// whose turns are not 0.
std::vector<std::vector<EdgeTurns>> continuousTurns(const BakeSource& source, std::span<const InnerEdge> edges,
                                                    const FrameList& all, std::span<const std::size_t> wanted);

// Returns dihedralAngles() with these turns added.
std::vector<float> continuousAngles(std::span<const InnerEdge> edges, std::span<const Vec3> positions,
                                    std::span<const EdgeTurns> turns);

}  // namespace penumbra
