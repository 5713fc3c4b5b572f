#pragma once
// Light that reaches the vertices of a member from other members and from a level ground: one diffuse bounce.
#include <span>
#include <vector>

#include "player/frame/frame_values.h"
#include "player/scene/character_light.h"
#include "player/scene/ground_glow.h"
#include "player/scene/scene_ground.h"
#include "runtime/evaluate/evaluator.h"
#include "sh/bounding_box.h"

namespace penumbra {

// The share of a white sky (0 to 1) that others hide from each vertex, and what the ground hides after them. A list is
// empty where nobody hides anything.
struct HiddenSky {
    std::vector<float> by_others, by_ground;  // [V]
    bool fromOthers() const { return !by_others.empty(); }
};

// The surface of a member as others see it, from near and from far.
struct ShiningMember {
    std::vector<Emitter> near, far;
    BoundingBox box;
};
// Replaces `out`, which keeps its room. `values` is what shiningVertices() show, [V].
void shiningMember(const FrameVertices& vertices, std::span<const std::uint32_t> triangles,
                   std::span<const Vec3> values, ShiningMember& out);

// The light that others may receive, from a level ground that casts (or null) and from members.
struct SentLight {
    const GroundGlow* ground = nullptr;
    std::span<const ShiningMember> members;
};
// The surfaces of all members from near.
void emittersOf(std::span<const ShiningMember> members, std::vector<Emitter>& out);

// Writes vertices.received: what the ground sends, pi times hidden.by_ground times its mean radiance.
void receiveFromGround(const GroundGlow& glow, const HiddenSky& hidden, int threads, FrameVertices& vertices);

// Adds what all others of `shining` send to member `index`: pi times hidden.by_others times their mean radiance as the
// anchors of the member see it (Evaluator::castLayout()).
void receiveFromOthers(const Evaluator& member, std::size_t index, std::span<const ShiningMember> shining,
                       const HiddenSky& hidden, FrameVertices& vertices);

// Adds what all of `shining` send to a Lambertian ground and what it sends back of it: albedo times the share of a
// white sky that casters hide from a vertex times their mean radiance, which is looked up at every fourth vertex of
// every fourth row. `radiance` is [side^2].
void addMembersLight(const GroundVertices& ground, std::span<const ShiningMember> shining, Vec3 albedo, int threads,
                     std::span<Vec3> radiance);

}  // namespace penumbra
