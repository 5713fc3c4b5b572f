#pragma once
// Dihedral angles of a clip that go on through +-pi: from the first sampled frame of the clip, each frame's angles are
// moved by whole turns to within pi of the frame before. A shard computes what the whole bake does: it starts at the
// first frame of the clip too.
#include <cstdint>
#include <span>
#include <vector>

#include "bake/bake_source.h"
#include "sh/dihedral_angles.h"

namespace penumbra {

// Only what is folded beyond a half turn has any.
struct EdgeTurns {
    std::uint32_t edge = 0;
    std::int32_t turns = 0;
};

// Of the frames of `all` (clips of `source`) with the ascending indices `wanted`: the edges whose turns are not 0.
std::vector<std::vector<EdgeTurns>> continuousTurns(const BakeSource& source, std::span<const InnerEdge> edges,
                                                    const FrameList& all, std::span<const std::size_t> wanted);

// dihedralAngles() with the turns added.
std::vector<float> continuousAngles(std::span<const InnerEdge> edges, std::span<const Vec3> positions,
                                    std::span<const EdgeTurns> turns);

}  // namespace penumbra
