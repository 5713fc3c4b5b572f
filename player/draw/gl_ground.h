#pragma once
// The ground of a scene on the GPU: it receives what GlCast casts, and shows weighted sums of it.
#include "player/draw/draw_frame.h"
#include "player/draw/gl_cast.h"

namespace penumbra {

// A mesh whose vertices all have one local frame.
struct GroundMesh {
    std::span<const Vec3> positions, normals, tangents;
    std::span<const std::uint32_t> triangles;
};

class GlGround {
public:
    // `channel` is shaded or ambient.
    GlGround(const GroundMesh& mesh, Channel channel);

    // Computes what each vertex shows: the sum of weight times number over the 21 numbers that `cast` leaves visible.
    void evaluate(GlCast& cast, std::span<const Vec3> weights);
    void draw(const FrameView& view) const;

private:
    std::size_t vertices_;
    GLsizei index_count_;
    GlObject receivers_, casts_, evaluate_, vertex_array_, triangles_, draw_;
    TextureBuffer evaluated_;
    GLint weights_, receiver_count_, vertex_count_;
    ViewUniforms view_;
};

}  // namespace penumbra
