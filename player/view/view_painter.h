#pragma once
// Draws the scene into the window's framebuffer.
#include <map>

#include "player/draw/model_painter.h"
#include "player/draw/overlay_painter.h"
#include "player/gl/gpu_timer.h"
#include "player/view/view_backdrop.h"
#include "player/view/view_layout.h"

namespace penumbra {

struct PaintCost {
    double upload = 0;                      // milliseconds
    double gpu_evaluate = 0, gpu_draw = 0;  // milliseconds on the GPU for an earlier frame; no meaning in software
};

class ScenePainter {
public:
    // `scene` outlives the painter.
    ScenePainter(const Scene& scene, EvaluationPath path);
    // Tells what updateScene() must compute for draw() and measureExposure().
    UpdateNeeds needs(const ViewState& state, int threads) const;
    void draw(const ViewState& state, int window_height, const Rectangle& picture, PaintCost& cost);
    // Returns the automatic exposure of the characters and the ground in the first pane, without its grid. The picture
    // must have shaded colours (view_look.h), and updateScene() must have been called. Leaves the window's
    // framebuffer bound.
    float measureExposure(const ViewState& state, const Rectangle& picture);

private:
    struct Key {
        std::size_t character;
        Shown shown;
        Channel channel;
        bool sunlit;
        bool pictured;
        auto operator<=>(const Key&) const = default;
    };
    // Characters of one file, which share the asset's data on the GPU and are drawn together.
    struct Group {
        std::vector<std::size_t> characters;
        std::shared_ptr<GlAsset> asset;  // made when it is first needed, as are the painters
        std::array<std::optional<ModelPainter>, kShownCount> painters;
    };
    const Scene* scene_;
    EvaluationPath path_;
    Backdrop backdrop_;
    std::optional<ViewSunlight> suns_;  // made when they first shine
    std::map<Key, ValuePainter> value_painters_;
    std::map<const Vec3*, PicturedMesh> pictures_;  // by where a file is mapped, of the characters that are uploaded
    std::vector<Group> groups_;
    std::vector<PosedCharacter> posed_;  // members of the current group
    std::vector<Vec3> sunlit_values_;    // values of the current character
    std::vector<GlCaster> casters_;
    std::optional<GlCast> cast_;  // made when it is first needed
    OverlayPainter overlays_;
    GpuTimer evaluate_timer_, draw_timer_;

    bool needsValues(const ViewState& state) const;
    bool castsOnGpu(const ViewState& state) const;
    bool fieldOnGpu(const ViewState& state) const { return scene_->field && castsOnGpu(state); }
    void poseCasters();
    void evaluate(Group& group, const ViewState& state, Shown shown, Vec3 eye);
    Key keyOf(const ViewState& state, std::size_t index, Shown shown) const;
    PicturedMesh picturesOf(const Character& character);
    void uploadValues(const ViewState& state, const Key& key);
    ViewSunlight* sunsFor(const ViewState& state);  // null where they do not shine
    // Uploads what the characters show in the panes, each once, and draws the maps of suns.
    void prepare(const ViewState& state, const std::vector<Pane>& panes, double radius);
    // Without `display` colours stay linear.
    void drawCharacters(const ViewState& state, const Pane& pane, double radius,
                        const std::optional<DisplayTransform>& display);
    void drawPane(const ViewState& state, const Pane& pane, double radius, int window_height);
    void drawBoxes(const ViewState& state, const Pane& pane, double radius);
    void drawLobe(const ViewState& state, const Pane& pane, double radius);
};

// Returns the view (column-major 4x4) of the camera for a pane of this shape, for a model that stands as
// `to_scene` says, and the eye in its frame.
FrameView paneView(const ViewState& state, const Rectangle& area, double scene_radius, const Affine& to_scene);

}  // namespace penumbra
