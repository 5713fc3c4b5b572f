#pragma once
// Draws one frame into the bound target.
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
    std::optional<DisplayTransform> display;  // unset: linear values, which pictures are written from
    float scale = 1;                          // factor on these linear values
};

// The places of a FrameView's members in a program; -1 where it does not use them.
struct ViewUniforms {
    GLint clip_from_model = -1, eye = -1, error_max = -1, exposure = -1, tone_map = -1;
};
ViewUniforms viewUniforms(const GlObject& program);
// Puts the program into use and the view into it.
void setView(const GlObject& program, const ViewUniforms& at, const FrameView& view);

// Tells which sides of triangles are drawn.
enum class Sides {
    kBoth,
    kSeen,   // only the outsides of closed surfaces (closed_surfaces.h), and both sides of others
    kFront,  // only fronts: in a two-sided mesh the backs have triangles of their own
};

// Draws vertices whose values were computed on the CPU.
class ValuePainter {
public:
    ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides = Sides::kBoth);
    // Draws `sides` of a mesh that is not two-sided.
    ValuePainter(const MeshView& mesh, Channel channel, Sides sides);
    void draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values);
    // The two halves of draw().
    void upload(std::span<const Vec3> positions, std::span<const Vec3> values);
    void draw(const FrameView& view) const;

private:
    GlObject program_, vertex_array_, positions_, values_, triangles_;
    ViewUniforms view_;
    Sides sides_;
    ClosedSurfaces surfaces_;  // only for kSeen
    bool outward_ = false;     // in the uploaded pose
    GLsizei index_count_;
};

}  // namespace penumbra
