#pragma once
// The ground of a scene on the GPU: it receives what GlCast casts, and shows weighted sums of it.
#include <optional>

#include "player/draw/evaluated_mesh.h"
#include "player/draw/gl_cast.h"

namespace penumbra {

// A mesh whose vertices all have one local frame.
struct GroundMesh {
    std::span<const Vec3> positions, normals, tangents;
    std::span<const std::uint32_t> triangles;
};

class GlGround {
public:
    // `channel` is shaded or ambient. Suns shine on it where it has lobes, which are Lambertian.
    GlGround(const GroundMesh& mesh, Channel channel, std::optional<SlotLobes> lobes = {});

    // Computes what each vertex shows: the sum of weight times number over the 21 numbers that `cast` leaves visible.
    void evaluate(GlCast& cast, std::span<const Vec3> weights);
    // `suns` are not null where they shine.
    void draw(const FrameView& view, const Sunlight* suns = nullptr) const { mesh_.draw(view, suns); }

private:
    EvaluatedMesh mesh_;
    std::optional<SlotLobes> lobes_;
    GlObject receivers_, casts_, evaluate_;
    GLint weights_, receiver_count_;
};

}  // namespace penumbra
