#pragma once
// Brings the origin of a scene near to who stands in it, where floats are fine.
#include <optional>

#include "formats/scene/ground_heights.h"

namespace penumbra {

// Opens the heights of the ground, if it has any, at their own time. Moves the origin of the scene by whole steps of
// 1,024 metres to its first character, or prop where it has none, and to the height of the ground there: all places of
// the description, and so those of the heights, count from SceneDescription::origin afterwards. A scene within half a
// step of its origin stays as it is. Throws what GroundHeights throws.
std::optional<GroundHeights> openGround(SceneDescription& scene);

}  // namespace penumbra
