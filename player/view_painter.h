#pragma once
// Draws the scene into the window's framebuffer.
#include <map>

#include "player/draw_frame.h"
#include "player/view_backdrop.h"
#include "player/view_layout.h"

namespace penumbra {

struct PaintCost {
    double upload = 0;  // milliseconds
};

class ScenePainter {
public:
    // `scene` outlives the painter.
    explicit ScenePainter(const Scene& scene, EvaluationPath path) : scene_(&scene), path_(path) {}
    EvaluationPath path() const { return path_; }
    void usePath(EvaluationPath path) { path_ = path; }
    // Whether this frame's values must be there on the CPU.
    bool needsValues(const ViewState& state) const;
    void draw(const ViewState& state, int window_height, const Rectangle& picture, PaintCost& cost);

private:
    struct Key {
        std::size_t character;
        Shown shown;
        Channel channel;
        auto operator<=>(const Key&) const = default;
    };
    const Scene* scene_;
    EvaluationPath path_;
    Backdrop backdrop_;
    std::map<Key, ValuePainter> value_painters_;
    std::map<Key, ModelPainter> model_painters_;

    std::optional<ValuePainter> lobe_;

    void drawLobe(const ViewState& state, const Pane& pane, double radius);
    void drawCharacter(std::size_t index, Shown shown, bool on_cpu, const FrameView& view, PaintCost& cost);
    ModelPainter& modelPainter(const Key& key, const Character& character);
};

// Column-major 4x4 of the camera for a pane of this shape, for a model that stands at `offset`.
FrameView paneView(const ViewState& state, const Rectangle& area, double scene_radius, Vec3 offset);

}  // namespace penumbra
