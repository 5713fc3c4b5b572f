#include "bake/fields/standing_parts.h"

#include <algorithm>

#include "formats/common/spread_evenly.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

// A point touches if it is no farther above the lowest point than this, in diagonals of the pose. A part stands if it
// touches in at least this share of the frames. findFeet() of the sphere blockers uses the same rule
// (fit/blockers/find_feet.h).
constexpr float kTouch = 0.025f;
constexpr double kMinTime = 0.2;
// A part touches where this share of its vertices does. The hem of a cape touches, too, but not its part.
constexpr double kMinShare = 0.25;
constexpr std::size_t kMaxFrames = 64;

std::vector<bool> touchingParts(std::span<const Vec3> positions, const PartTable& table) {
    const BoundingBox box = boundsOf(positions);
    const float reach = box.low.y + kTouch * length(box.high - box.low);
    std::vector<std::size_t> vertices(table.partCount()), touching(table.partCount());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        ++vertices[table.part_of_vertex[v]];
        touching[table.part_of_vertex[v]] += positions[v].y <= reach;
    }
    std::vector<bool> touches;
    for (std::size_t p = 0; p < vertices.size(); ++p)
        touches.push_back(touching[p] > 0 && double(touching[p]) >= kMinShare * double(vertices[p]));
    return touches;
}

}  // namespace

std::vector<bool> standingParts(const BakeSource& source, const PartTable& table) {
    // 1. Frames at equal steps over all clips.
    const FrameList frames = sampleFrames(source, {}, 0);
    const std::vector<int> clips = clipIndices(source, frames.clip_names);
    const std::vector<std::size_t> looked_at = spreadEvenly(frames.frameCount(), kMaxFrames);
    // 2. In how many of them each part touches.
    std::vector<std::size_t> touched(table.partCount());
    for (const std::size_t f : looked_at) {
        const std::vector<bool> touches =
            touchingParts(sourcePositions(source, clips[frames.clip[f]], frames.time[f]), table);
        for (std::size_t p = 0; p < touched.size(); ++p) touched[p] += touches[p];
    }
    std::vector<bool> stands;
    for (const std::size_t n : touched) stands.push_back(double(n) >= kMinTime * double(looked_at.size()));
    return stands;
}

}  // namespace penumbra
