#pragma once
#include <span>

#include "player/draw_frame.h"
#include "player/render_options.h"

namespace penumbra {

// The view of a picture: the camera frames this frame's skinned positions with half the rest pose's diagonal as the
// radius, as penumbra-bake reference does, so that the pictures lie over each other. UsageError names --camera.
FrameView makePictureView(const RenderOptions& options, const AssetView& asset, std::span<const Vec3> positions);

}  // namespace penumbra
