#pragma once
// A picture of a scene: everyone casts on everyone else, on props and on the ground.
#include "formats/image/image_file.h"
#include "player/frame/render_options.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Draws what the scene shows, as its camera or options.camera sees it. Of the options it reads size, camera, channel
// (shaded or ambient), shading, backend and samples. Returns linear Rec.709 with alpha, as OffscreenRenderer does.
// Shaded members need materials, and the scene a light: UsageError.
Image drawScene(const PosedScene& scene, const RenderOptions& options, int threads);

}  // namespace penumbra
