#include "player/scene/received_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "formats/common/parallel_for.h"
#include "player/scene/emitter_kernel.h"

namespace penumbra {

namespace {

constexpr float kHalfSphere = std::numbers::pi_v<float>;  // E of a white sky in irradiance
constexpr float kMinHidden = 1e-3f;                       // share of a white sky below which nothing is received

// How far two boxes are apart, 0 where they touch.
float gapBetween(const BoundingBox& a, const BoundingBox& b) {
    Vec3 gap;
    for (int axis = 0; axis < 3; ++axis)
        gap[axis] = std::max({a.low[axis] - b.high[axis], b.low[axis] - a.high[axis], 0.0f});
    return length(gap);
}

// Emitters of everyone but one, those that are far in less detail.
void emittersAround(std::size_t index, std::span<const ShiningMember> shining, std::vector<Emitter>& out) {
    constexpr float kNear = 1;  // diagonals of the member that shines
    out.clear();
    for (std::size_t m = 0; m < shining.size(); ++m) {
        if (m == index || shining[m].near.empty()) continue;
        const bool near = gapBetween(shining[index].box, shining[m].box) < kNear * 2 * shining[m].box.radius();
        const std::vector<Emitter>& from = near ? shining[m].near : shining[m].far;
        out.insert(out.end(), from.begin(), from.end());
    }
}

// Points that see emitters, and the mean radiance of what each sees. It keeps its room.
struct Means {
    std::vector<Vec3> positions, normals, means;

    void clear() { positions.clear(), normals.clear(); }
    void add(Vec3 position, Vec3 normal) {
        positions.push_back(position);
        normals.push_back(normal);
    }
    void find(std::span<const Emitter> emitters) {
        means.resize(positions.size());
        find(emitters, 0, positions.size());
    }
    // Finds the means of points [begin, end). `means` has room for all.
    void find(std::span<const Emitter> emitters, std::size_t begin, std::size_t end) {
        fastestEmitterPath().mean(emitters.data(), emitters.size(),
                                  {positions.data() + begin, normals.data() + begin, end - begin},
                                  means.data() + begin);
    }
};

void receive(const HiddenSky& hidden, std::size_t v, Vec3 radiance, FrameVertices& vertices) {
    vertices.received[v] += radiance * (kHalfSphere * hidden.by_others[v]);
}

}  // namespace

void shiningMember(const FrameVertices& vertices, std::span<const std::uint32_t> triangles,
                   std::span<const Vec3> values, ShiningMember& out) {
    constexpr float kCells = 8;  // along the diagonal of the member's box
    thread_local std::vector<ShiningVertex> shining;
    out.near.clear(), out.far.clear(), shining.clear();
    out.box = boundsOf(vertices.positions);
    const float diagonal = 2 * float(out.box.radius());
    if (!(diagonal > 0)) return;
    addShining({vertices.positions, vertices.normals, triangles, values}, shining);
    emittersOf(shining, diagonal / kCells, out.near);
    emittersOf(shining, diagonal / 2, out.far);
}

void emittersOf(std::span<const ShiningMember> members, std::vector<Emitter>& out) {
    out.clear();
    for (const ShiningMember& member : members) out.insert(out.end(), member.near.begin(), member.near.end());
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

void receiveFromOthers(const Evaluator& member, std::size_t index, std::span<const ShiningMember> shining,
                       const HiddenSky& hidden, FrameVertices& vertices) {
    thread_local std::vector<Emitter> emitters;
    thread_local Means at_anchors, alone;
    thread_local std::vector<std::size_t> lonely;  // vertices without anchors
    emittersAround(index, shining, emitters);
    if (emitters.empty() || !hidden.fromOthers()) return;
    const FarLayout& layout = member.castLayout();
    const auto isHidden = [&](std::size_t v) { return hidden.by_others[v] > kMinHidden; };
    at_anchors.clear(), lonely.clear(), alone.clear();
    for (const std::uint32_t v : layout.anchors) at_anchors.add(vertices.positions[v], vertices.normals[v]);
    at_anchors.find(emitters);
    for (const FarRun& run : layout.runs)
        for (std::size_t r = run.first; r < run.first + run.count; ++r) {
            const std::size_t v = layout.receivers[r];
            if (!isHidden(v)) continue;
            if (run.anchor_count == 0) {
                lonely.push_back(v);
                continue;
            }
            Vec3 mean;
            for (std::size_t k = kAnchorsOfReceiver * r; k < kAnchorsOfReceiver * (r + 1); ++k)
                mean += at_anchors.means[run.first_anchor + layout.anchor[k]] * layout.weight[k];
            receive(hidden, v, mean, vertices);
        }
    for (std::size_t v = member.firstFollower(); v < vertices.positions.size(); ++v)
        if (isHidden(v)) lonely.push_back(v);
    for (const std::size_t v : lonely) alone.add(vertices.positions[v], vertices.normals[v]);
    alone.find(emitters);
    for (std::size_t i = 0; i < lonely.size(); ++i) receive(hidden, lonely[i], alone.means[i], vertices);
}

namespace {

// A block of a ground's vertices, with its far edges.
struct GroundBlock {
    std::uint32_t top, left, bottom, right;

    bool any(std::uint32_t side, const auto& test) const {
        for (std::uint32_t i = top; i <= bottom; ++i)
            for (std::uint32_t j = left; j <= right; ++j)
                if (test(std::size_t(i) * side + j)) return true;
        return false;
    }
    // Calls body(vertex, value between those of the corners) for all vertices but those of far edges, which belong to
    // the next blocks unless there are none.
    void interpolate(std::uint32_t side, const std::array<Vec3, 4>& corners, const auto& body) const {
        const std::uint32_t end_row = bottom + (bottom + 1 == side ? 1 : 0),
                            end_column = right + (right + 1 == side ? 1 : 0);
        for (std::uint32_t i = top; i < end_row; ++i)
            for (std::uint32_t j = left; j < end_column; ++j) {
                const float down = float(i - top) / float(bottom - top), across = float(j - left) / float(right - left);
                const Vec3 above = corners[0] * (1 - across) + corners[1] * across,
                           below = corners[2] * (1 - across) + corners[3] * across;
                body(std::size_t(i) * side + j, above * (1 - down) + below * down);
            }
    }
};

// The room that addMembersLight() works in, which a thread keeps.
struct GroundRoom {
    std::vector<Emitter> emitters;
    std::vector<float> e;              // [side^2] of the ground
    std::vector<std::uint8_t> shaded;  // one for each block
    std::vector<std::uint32_t> corner_of;
    Means corners;
};

}  // namespace

void addMembersLight(const GroundVertices& ground, std::span<const ShiningMember> shining, Vec3 albedo, int threads,
                     std::span<Vec3> radiance) {
    constexpr std::uint32_t kMeanStep = 4;   // vertices between two where the mean is looked up
    constexpr std::size_t kMeanPiece = 128;  // points that a thread takes at once
    thread_local GroundRoom of_thread;
    GroundRoom& room = of_thread;  // other threads have one of their own
    std::vector<Emitter>& emitters = room.emitters;
    std::vector<float>& e = room.e;
    emittersOf(shining, emitters);
    if (emitters.empty()) return;
    groundAmbient(ground, e);
    const std::uint32_t side = ground.side, last = side - 1, blocks = (last + kMeanStep - 1) / kMeanStep;
    const std::uint32_t nodes = blocks + 1;  // corners of blocks, a side
    const auto place = [&](std::uint32_t node) { return std::min(node * kMeanStep, last); };
    const auto isHidden = [&](std::size_t v) { return 1 - e[v] > kMinHidden; };
    // 1. Find the blocks where somebody hides something of the sky.
    const auto blockOf = [&](std::size_t b) {
        const std::uint32_t i = std::uint32_t(b) / blocks, j = std::uint32_t(b) % blocks;
        return GroundBlock{place(i), place(j), place(i + 1), place(j + 1)};
    };
    std::vector<std::uint8_t>& shaded = room.shaded;
    shaded.assign(std::size_t(blocks) * blocks, 0);
    parallelFor(shaded.size(), threads, [&](std::size_t b) { shaded[b] = blockOf(b).any(side, isHidden); });
    // 2. Look up the mean at their corners, once for all blocks that share one.
    const auto isCorner = [&](std::uint32_t i, std::uint32_t j) {
        for (std::uint32_t row = i > 0 ? i - 1 : 0; row <= i && row < blocks; ++row)
            for (std::uint32_t column = j > 0 ? j - 1 : 0; column <= j && column < blocks; ++column)
                if (shaded[std::size_t(row) * blocks + column] != 0) return true;
        return false;
    };
    Means& corners = room.corners;
    std::vector<std::uint32_t>& corner_of = room.corner_of;
    corners.clear();
    corner_of.assign(std::size_t(nodes) * nodes, 0);
    for (std::uint32_t i = 0; i < nodes; ++i)
        for (std::uint32_t j = 0; j < nodes; ++j) {
            if (!isCorner(i, j)) continue;
            corner_of[std::size_t(i) * nodes + j] = std::uint32_t(corners.positions.size());
            corners.add(ground.positions[std::size_t(place(i)) * side + place(j)], {0, 1, 0});
        }
    corners.means.resize(corners.positions.size());
    parallelFor((corners.positions.size() + kMeanPiece - 1) / kMeanPiece, threads, [&](std::size_t piece) {
        const std::size_t end = std::min((piece + 1) * kMeanPiece, corners.positions.size());
        corners.find(emitters, piece * kMeanPiece, end);
    });
    const auto meanAt = [&](std::size_t n) { return corners.means[corner_of[n]]; };
    // 3. Vertices get what is between them.
    parallelFor(shaded.size(), threads, [&](std::size_t b) {
        if (shaded[b] == 0) return;
        const std::size_t n = b / blocks * nodes + b % blocks;
        blockOf(b).interpolate(side, {meanAt(n), meanAt(n + 1), meanAt(n + nodes), meanAt(n + nodes + 1)},
                               [&](std::size_t v, Vec3 mean) {
                                   if (isHidden(v)) radiance[v] += albedo * (mean * (1 - e[v]));
                               });
    });
}

}  // namespace penumbra
