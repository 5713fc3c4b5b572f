#pragma once
// Draws what is behind and below the characters: the light as they see it, and a ground plane.
#include <map>
#include <optional>

#include "player/draw/draw_frame.h"
#include "player/draw/sky_painter.h"
#include "player/view/view_field.h"
#include "player/view/view_scene.h"
#include "player/view/view_shapes.h"
#include "player/view/view_sunlight.h"

namespace penumbra {

// Tells whether the ground is drawn. From below it would hide everyone, and it has no difference from a truth.
bool showsGround(const Scene& scene, const ViewState& state);

class Backdrop {
public:
    // Draws into the pane that is set, and clears its depth. `view` has the pane's camera. `suns` have shone where
    // showsSuns(), and are null elsewhere.
    void draw(const Scene& scene, const ViewState& state, const FrameView& view, ViewSunlight* suns);
    // Draws the ground without its tiles.
    void drawPlainGround(const Scene& scene, const FrameView& view, ViewSunlight* suns);
    // The ground with heights on the GPU, which drawPlainGround() draws from now on.
    ViewField& fieldOnGpu(const Scene& scene);
    // From now on it draws what updateScene() has computed.
    void drawFieldOfCpu() { field_on_gpu_ = false; }

private:
    Cached<LightKey, std::optional<SkyPainter>> sky_;
    std::map<bool, ValuePainter> plain_ground_, ground_;  // by whether suns shine on them
    std::optional<ViewField> field_;                      // made when it is first needed
    bool field_on_gpu_ = false;
    std::vector<Vec3> field_values_;
    GroundTiles tiles_;
    Cached<GroundKey> uploaded_;  // key of ground_, which is replaced when suns come or go

    void drawSky(const Scene& scene, const ViewState& state, const FrameView& view);
    void drawGround(const Scene& scene, const FrameView& view, const ViewSunlight* suns);
};

}  // namespace penumbra
