#include "player/scene/received_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr float kHalfSphere = std::numbers::pi_v<float>;  // of a white sky: E in irradiance
constexpr float kMinHidden = 1e-3f;                       // of a white sky, below which nothing is received

// How far two boxes are apart, 0 where they touch.
float gapBetween(const BoundingBox& a, const BoundingBox& b) {
    Vec3 gap;
    for (int axis = 0; axis < 3; ++axis)
        gap[axis] = std::max({a.low[axis] - b.high[axis], b.low[axis] - a.high[axis], 0.0f});
    return length(gap);
}

// Emitters of everyone but one, those that are far in less detail.
std::vector<Emitter> emittersAround(std::size_t index, std::span<const ShiningMember> shining) {
    constexpr float kNear = 1;  // diagonals of the member that shines
    std::vector<Emitter> out;
    for (std::size_t m = 0; m < shining.size(); ++m) {
        if (m == index || shining[m].near.empty()) continue;
        const bool near = gapBetween(shining[index].box, shining[m].box) < kNear * 2 * shining[m].box.radius();
        const std::vector<Emitter>& from = near ? shining[m].near : shining[m].far;
        out.insert(out.end(), from.begin(), from.end());
    }
    return out;
}

void receive(const HiddenSky& hidden, std::size_t v, Vec3 radiance, FrameVertices& vertices) {
    vertices.received[v] += radiance * (kHalfSphere * hidden.by_others[v]);
}

}  // namespace

ShiningMember shiningMember(const FrameVertices& vertices, std::span<const std::uint32_t> triangles,
                            std::span<const Vec3> values) {
    constexpr float kCells = 8;  // along the diagonal of the member's box
    ShiningMember out;
    out.box = boundsOf(vertices.positions);
    const float diagonal = 2 * float(out.box.radius());
    if (!(diagonal > 0)) return out;
    std::vector<ShiningVertex> shining;
    addShining({vertices.positions, vertices.normals, triangles, values}, shining);
    out.near = emittersOf(shining, diagonal / kCells);
    out.far = emittersOf(shining, diagonal / 2);
    return out;
}

void receiveFromGround(const GroundGlow& glow, const HiddenSky& hidden, int threads, FrameVertices& vertices) {
    constexpr std::size_t kVertices = 512;
    const std::size_t count = vertices.positions.size();
    vertices.received.assign(count, Vec3{});
    if (hidden.by_ground.empty()) return;
    parallelFor((count + kVertices - 1) / kVertices, threads, [&](std::size_t piece) {
        for (std::size_t v = piece * kVertices; v < std::min(count, (piece + 1) * kVertices); ++v)
            if (hidden.by_ground[v] > kMinHidden)
                vertices.received[v] =
                    glow.radianceAt(vertices.positions[v], vertices.normals[v]) * (kHalfSphere * hidden.by_ground[v]);
    });
}

void receiveFromOthers(const SceneMember& member, std::size_t index, std::span<const ShiningMember> shining,
                       const HiddenSky& hidden, FrameVertices& vertices) {
    const std::vector<Emitter> emitters = emittersAround(index, shining);
    if (emitters.empty() || !hidden.fromOthers()) return;
    const FarLayout& layout = member.evaluator.castLayout();
    const auto seenBy = [&](std::size_t v) {
        return meanRadiance(emitters, vertices.positions[v], vertices.normals[v]);
    };
    std::vector<Vec3> at_anchor(layout.anchors.size());
    for (std::size_t a = 0; a < at_anchor.size(); ++a) at_anchor[a] = seenBy(layout.anchors[a]);
    for (const FarRun& run : layout.runs)
        for (std::size_t r = run.first; r < run.first + run.count; ++r) {
            const std::size_t v = layout.receivers[r];
            if (!(hidden.by_others[v] > kMinHidden)) continue;
            Vec3 mean;
            for (std::size_t k = 4 * r; run.anchor_count > 0 && k < 4 * r + 4; ++k)
                mean += at_anchor[run.first_anchor + layout.anchor[k]] * layout.weight[k];
            receive(hidden, v, run.anchor_count > 0 ? mean : seenBy(v), vertices);
        }
    for (std::size_t v = member.evaluator.firstFollower(); v < vertices.positions.size(); ++v)
        if (hidden.by_others[v] > kMinHidden) receive(hidden, v, seenBy(v), vertices);
}

}  // namespace penumbra
