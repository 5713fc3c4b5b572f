#pragma once
// How characters stand that no scene's file places: in a row along x, on a ground that lies under the lowest of them.
#include <filesystem>
#include <span>
#include <vector>

#include "formats/scene/scene_file.h"
#include "sh/bounding_box.h"

namespace penumbra {

// Returns how far each is moved along x. Boxes hold rest poses. Each gets the width of the widest and a third more.
std::vector<float> placesSideBySide(std::span<const BoundingBox> boxes);

// `box` holds everyone's rest pose.
constexpr int kGroundUnderResolution = 145;
SceneGround groundUnder(const BoundingBox& box);

// Returns the scene of these assets, as if a file said so. Everyone is in the first frame of the first clip, and the
// light is the first of the first asset. Throws what OpenAsset throws, and InvalidInput for an asset without a model.
SceneDescription sceneSideBySide(std::span<const std::filesystem::path> assets);

}  // namespace penumbra
