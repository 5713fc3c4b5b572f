#pragma once
// The constants of fit/reflectance/shading_scenes.h, in the order of occluders and lights.
#include <array>

#include "fit/reflectance/shading_scenes.h"

namespace penumbra {

extern const std::array<OccluderPart, 291> kSceneParts;
extern const std::array<int, 61> kScenePartCounts;  // parts of each occluder; they add up to the number of parts
extern const std::array<Vec3d, 54> kSceneViews;
extern const std::array<std::array<double, 16>, 6> kSceneLights;

}  // namespace penumbra
