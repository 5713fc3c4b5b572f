#pragma once
// Drawing one frame into the bound target.
#include <array>
#include <optional>
#include <span>

#include "formats/asset/asset_file.h"
#include "player/draw/closed_surfaces.h"
#include "player/draw/view_display.h"
#include "player/frame/channel.h"
#include "player/gl/gl_objects.h"
#include "sh/vec3.h"

namespace penumbra {

struct FrameView {
    std::array<float, 16> clip_from_model{};  // column-major
    Vec3 eye;                                 // model frame
    float error_max = 0.25f;
    std::optional<DisplayTransform> display;  // unset: linear values, as pictures are written from
};

// Where a program takes a FrameView; -1 where it does not.
struct ViewUniforms {
    GLint clip_from_model = -1, eye = -1, error_max = -1, exposure = -1, tone_map = -1;
};
ViewUniforms viewUniforms(const GlObject& program);
// Puts the program in use and the view into it.
void setView(const GlObject& program, const ViewUniforms& at, const FrameView& view);

// Which sides of triangles are drawn.
enum class Sides {
    kBoth,
    kSeen,   // closed surfaces (closed_surfaces.h) from their outside alone; the others both
    kFront,  // all from their front alone: of a two-sided mesh, whose backs have triangles of their own
};

// Draws vertices whose values were computed on the CPU.
class ValuePainter {
public:
    ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides = Sides::kBoth);
    // Of a mesh that is not two-sided `sides`.
    ValuePainter(const MeshView& mesh, Channel channel, Sides sides);
    void draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values);
    // Its two halves.
    void upload(std::span<const Vec3> positions, std::span<const Vec3> values);
    void draw(const FrameView& view) const;

private:
    GlObject program_, vertex_array_, positions_, values_, triangles_;
    ViewUniforms view_;
    Sides sides_;
    ClosedSurfaces surfaces_;  // of kSeen
    bool outward_ = false;     // in the uploaded pose
    GLsizei index_count_;
};

}  // namespace penumbra
