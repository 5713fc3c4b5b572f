#pragma once
// How a frame is seen, and the uniforms that tell it to a program.
#include <array>
#include <optional>

#include "player/draw/view_display.h"
#include "player/gl/gl_objects.h"
#include "sh/vec3.h"

namespace penumbra {

struct FrameView {
    std::array<float, 16> clip_from_model{};  // column-major
    Vec3 eye;                                 // model frame
    float error_max = 0.25f;
    std::optional<DisplayTransform> display;  // unset: linear values, which pictures are written from
    float scale = 1;                          // factor on these linear values
    Affine scene_from_model;                  // a rotation and a translation
    // x and z of a middle, model frame, and the distances from it where something that fades begins to and has gone
    // (Sides::kFading).
    std::array<float, 4> rim{};
};

// The places of a FrameView's members in a program; -1 where it does not use them.
struct ViewUniforms {
    GLint clip_from_model = -1, eye = -1, error_max = -1, exposure = -1, tone_map = -1, rim = -1;
};
ViewUniforms viewUniforms(const GlObject& program);
// Puts the program into use and the view into it.
void setView(const GlObject& program, const ViewUniforms& at, const FrameView& view);

}  // namespace penumbra
