#pragma once
// A picture of a scene: everyone casts on everyone else, on props and on the ground.
#include <optional>

#include "formats/image/image_file.h"
#include "player/frame/render_options.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

struct ScenePicture {
    Image image;               // linear Rec.709 with alpha, as OffscreenRenderer has it
    std::optional<Image> sky;  // the background; only with options.light_background
};

// Draws what the scene shows, as its camera or options.camera sees it. Of the options it reads size, camera, channel
// (shaded, ambient or error), shading, suns, backend, samples and light_background. Shaded members need materials, and
// the scene a light: UsageError. `truth` is for the error channel, see SceneFrames.
ScenePicture drawScene(const PosedScene& scene, const RenderOptions& options, int threads,
                       const AssetView* truth = nullptr);

}  // namespace penumbra
