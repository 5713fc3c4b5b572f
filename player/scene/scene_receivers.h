#pragma once
// What the vertices of a scene see past its casters.
#include "player/frame/frame_values.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Computes the vertices of a member in the scene, with numbers past its own parts and all other casters. Where nobody
// casts on it, these are the very numbers that it has alone.
FrameVertices memberVertices(const PosedScene& scene, std::size_t member, int threads);

}  // namespace penumbra
