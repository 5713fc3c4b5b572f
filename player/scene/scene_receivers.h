#pragma once
// What the vertices of a scene see past its casters.
#include "player/frame/frame_values.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Multiplies numbers of the model's convention [receivers, stride] by what the chosen casters leave visible. Returns
// whether any of the receivers sees one; without, the numbers stay the very ones that they were.
bool castOnNumbers(const CastShadow& cast, CasterChoice choice, const CastReceivers& receivers, const ModelView& model,
                   int threads, std::span<float> numbers);

// Writes the vertices of a member in the scene. Their numbers stay what they are.
void skinMember(const SceneMember& member, int threads, FrameVertices& vertices);
// Sizes `vertices`, which may hold those of a frame before. Computes the vertices of a member in the scene, with its
// own numbers alone.
void ownVertices(const SceneMember& member, int threads, FrameVertices& vertices);

// Sizes `vertices`, which may hold those of a frame before. Computes the vertices of a member in the scene, with
// numbers past its own parts and all other casters. Where nobody casts on it, these are the very numbers that it has
// alone.
void memberVertices(const PosedScene& scene, std::size_t member, int threads, FrameVertices& vertices);
FrameVertices memberVertices(const PosedScene& scene, std::size_t member, int threads);

}  // namespace penumbra
