#pragma once
// Draws frames of a scene as the window does, one after another, with GL objects that stay.
#include <optional>
#include <vector>

#include "player/draw/draw_frame.h"
#include "player/draw/sunlight.h"
#include "player/gl/offscreen_target.h"
#include "player/render/scene_frames.h"

namespace penumbra {

class SceneDrawing {
public:
    // `frames` has been shaded, and outlives this object.
    SceneDrawing(const PosedScene& scene, const SceneFrames& frames, const RenderOptions& options);

    // The steps of a picture, in their order: the maps of the suns, if there are any; upload and drawing; reading back.
    void drawMaps();
    void drawMeshes();
    void read() { target_.readBytes(picture_); }

private:
    const SceneFrames* frames_;
    OffscreenTarget target_;
    std::optional<Sunlight> suns_;
    std::vector<ValuePainter> painters_;
    std::vector<std::uint8_t> picture_;
};

}  // namespace penumbra
