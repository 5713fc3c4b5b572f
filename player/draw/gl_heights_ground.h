#pragma once
// Shades and draws the points of a height field on the GPU.
#include <optional>

#include "player/draw/evaluated_mesh.h"
#include "player/draw/gl_cast.h"
#include "player/draw/gl_heights.h"
#include "player/draw/shader_source.h"
#include "player/gl/upload_ring.h"

namespace penumbra {

// The lobes of a ground that suns shine on.
struct GroundLobes {
    SlotLobes lobes;
    BrdfModels models = 0;
};

class GlHeightsGround {
public:
    // `triangles` are of the field's points. Without `shading` the points show E. `heights` and `shading` outlive this
    // object; suns shine where there are lobes.
    GlHeightsGround(const GlHeights& heights, std::span<const std::uint32_t> triangles, const ShadingSet* shading,
                    std::optional<GroundLobes> lobes = {});

    // Computes what every point shows to `eye`, past what `cast` leaves visible; null: nobody casts.
    void evaluate(GlCast* cast, Vec3 eye);
    // `suns` are not null where they shine.
    void draw(const FrameView& view, const Sunlight* suns = nullptr) const { mesh_.draw(view, suns); }

private:
    const GlHeights* heights_;
    const ShadingSet* shading_;
    std::optional<ShadingLayout> layout_;
    std::optional<GroundLobes> lobes_;
    EvaluatedMesh mesh_;
    GlObject open_, past_casters_;                   // the programs, made when they are first needed
    GlObject receiver_program_, receivers_, casts_;  // made when somebody casts
    TextureBuffer materials_;
    std::optional<UploadRing> light_;

    HeightsRecipe recipe() const;
    void castOnPoints(GlCast& cast);
};

}  // namespace penumbra
