#pragma once
// Drawing one frame into the bound target, on either path.
#include <array>

#include "player/gl_upload.h"

namespace penumbra {

struct FrameView {
    std::array<float, 16> clip_from_model{};  // column-major
    Vec3 eye;                                 // model frame
    float error_max = 0.25f;
};

// Draws vertices whose values were computed on the CPU.
class ValuePainter {
public:
    ValuePainter(std::span<const std::uint32_t> triangles, Channel channel);
    void draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values) const;

private:
    GlObject program_, vertex_array_, positions_, values_, triangles_;
    GLsizei index_count_;
};

// Draws an asset that the vertex shader evaluates.
class ModelPainter {
public:
    // `material` and `light`: for kShaded only, else null. numbers_given: setNumbers() replaces the model's numbers.
    ModelPainter(const AssetView& asset, Channel channel, const MaterialView* material, const LightView* light,
                 bool numbers_given);
    void setPose(const Evaluator& evaluator, std::span<const Affine> bones);
    void setNumbers(std::span<const float> numbers);  // [V, stride]
    void setTrueAmbient(std::span<const float> e);    // [V], for kError
    void draw(const FrameView& view) const;

private:
    GlModel model_;
    GlObject program_, slices_, light_, true_ambient_;
};

}  // namespace penumbra
