#pragma once
// Drawing one frame into the bound target, on either path.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "player/gl_upload.h"
#include "player/shading_buffers.h"
#include "player/view_display.h"

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

// Draws vertices whose values were computed on the CPU.
class ValuePainter {
public:
    ValuePainter(std::span<const std::uint32_t> triangles, Channel channel);
    void draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values) const;
    // Its two halves.
    void upload(std::span<const Vec3> positions, std::span<const Vec3> values) const;
    void draw(const FrameView& view) const;

private:
    GlObject program_, vertex_array_, positions_, values_, triangles_;
    ViewUniforms view_;
    GLsizei index_count_;
};

// Draws an asset that the vertex shader evaluates.
class ModelPainter {
public:
    // `shading`: for kShaded only, else null; what is on in it when draw() is called is what is drawn, and it outlives
    // the painter. numbers_given: setNumbers() replaces the model's numbers.
    ModelPainter(const AssetView& asset, Channel channel, const ShadingSet* shading, bool numbers_given);
    void setPose(const Evaluator& evaluator, std::span<const Affine> bones);
    void setNumbers(std::span<const float> numbers);  // [V, stride]
    void setTrueAmbient(std::span<const float> e);    // [V], for kError
    void draw(const FrameView& view);

private:
    GlModel model_;
    GlObject program_, true_ambient_;
    ViewUniforms view_;
    std::vector<std::string> samplers_;  // that the program reads, by texture unit
    std::optional<ShadingBuffers> shading_;
};

}  // namespace penumbra
