#pragma once
#include <span>

#include "player/draw/draw_frame.h"
#include "player/frame/orbit_camera.h"
#include "player/frame/posed_frame.h"
#include "player/frame/render_options.h"

namespace penumbra {

// Returns the view of a picture. The camera frames this frame's skinned positions with half the rest pose's diagonal
// as the radius and with defaultPitch(), as penumbra-bake reference does, so that the pictures lie over each other.
// Throws BadOption "camera".
FrameView makePictureView(const RenderOptions& options, const AssetView& asset, std::span<const Vec3> positions);

// Returns one view for a whole sequence, so that nothing jumps. `box` holds every frame (boundsOfClips()). The radius
// is half its diagonal where that is more than half the rest pose's.
FrameView makeSequenceView(const RenderOptions& options, const AssetView& asset, const BoundingBox& box);

// Returns the box of the skinned positions of all frames of these clips. It covers all frames, and not only those
// that a run draws, so that runs of other frames of the clips have the same view. `frame` loses its pose.
BoundingBox boundsOfClips(PosedFrame& frame, std::span<const std::size_t> clips);

}  // namespace penumbra
