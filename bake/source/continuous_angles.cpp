#include "bake/source/continuous_angles.h"

#include <algorithm>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

// Keeps the unwrapped angles of the frame before.
struct Unwrapper {
    std::vector<float> before;

    // Returns the turns of the next frame's angles that bring each one nearest to the frame before.
    std::vector<EdgeTurns> add(std::span<const float> angles) {
        std::vector<EdgeTurns> out;
        if (before.empty()) before.assign(angles.begin(), angles.end());
        for (std::size_t e = 0; e < angles.size(); ++e) {
            const int turns = turnsTowards(before[e], angles[e]);
            before[e] = addTurns(angles[e], turns);
            if (turns != 0) out.push_back({std::uint32_t(e), turns});
        }
        return out;
    }
};

}  // namespace

std::vector<std::vector<EdgeTurns>> continuousTurns(const BakeSource& source, std::span<const InnerEdge> edges,
                                                    const FrameList& all, std::span<const std::size_t> wanted) {
    constexpr std::size_t kBlock = 64;  // frames in memory
    std::vector<std::vector<EdgeTurns>> out(wanted.size());
    const std::vector<int> clips = clipIndices(source, all.clip_names);
    for (std::size_t first = 0, next = 0; next < wanted.size();) {
        // 1. Go back to the clip's first frame, and forward to its last wanted one.
        const std::uint16_t clip = all.clip[wanted[next]];
        first = std::size_t(std::lower_bound(all.clip.begin(), all.clip.end(), clip) - all.clip.begin());
        std::size_t last = next;  // the last wanted frame of this clip
        while (last + 1 < wanted.size() && all.clip[wanted[last + 1]] == clip) ++last;
        Unwrapper unwrapper;
        // 2. Many threads compute the angles of a block of frames. Unwrapping then goes through the block in order.
        for (std::size_t begin = first; begin <= wanted[last]; begin += kBlock) {
            throwIfInterrupted();
            std::vector<std::vector<float>> angles(std::min(kBlock, wanted[last] + 1 - begin));
            parallelFor(angles.size(), 0, [&](std::size_t i) {
                const std::vector<Vec3> positions = sourcePositions(source, clips[clip], all.time[begin + i]);
                angles[i].resize(edges.size());
                dihedralAngles(edges, positions, angles[i]);
            });
            for (std::size_t i = 0; i < angles.size(); ++i) {
                std::vector<EdgeTurns> turns = unwrapper.add(angles[i]);
                if (next <= last && wanted[next] == begin + i) out[next++] = std::move(turns);
            }
        }
    }
    return out;
}

std::vector<float> continuousAngles(std::span<const InnerEdge> edges, std::span<const Vec3> positions,
                                    std::span<const EdgeTurns> turns) {
    std::vector<float> angles(edges.size());
    dihedralAngles(edges, positions, angles);
    for (const EdgeTurns& turn : turns) angles[turn.edge] = addTurns(angles[turn.edge], turn.turns);
    return angles;
}

}  // namespace penumbra
