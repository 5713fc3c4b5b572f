#pragma once
// How everyone of a scene stands, for every program that poses it.
#include "formats/asset/asset_file.h"
#include "formats/scene/scene_file.h"
#include "sh/camera.h"

namespace penumbra {

// From the frame of its asset to the scene.
Affine placementOf(const SceneCharacter& one);

// Returns the frame of the asset's animation that is nearest to `seconds`, by default to its own time, in its clip.
// Throws InvalidInput, which names the place in the file, for a clip that is not there.
std::size_t frameOf(const SceneCharacter& one, const AnimationView& animation, std::optional<double> seconds);

// Returns the material of each slot of the asset's mesh, or one for all of a mesh without slots. Throws InvalidInput
// for slots or materials that are not there, and where the asset has no material.
std::vector<std::size_t> materialsOf(const SceneCharacter& one, const AssetView& asset);

// Returns the scene's light in the asset that it is taken from; null for an asset without lights where the scene names
// none. Throws InvalidInput for lights that are not there.
const LightView* lightOf(const SceneLight& light, const AssetView& asset);
// Throws InvalidInput for what is not a rotation.
Mat3d rotationOf(const SceneLight& light);

// Frames points of all members: as `option` says (sh/camera.h), or the file where that is empty. Throws UsageError and
// InvalidInput.
Camera cameraOf(const SceneDescription& scene, const std::string& option, std::span<const Vec3> points);

}  // namespace penumbra
