#include "fit/reflectance/shading_scenes.h"

#include <algorithm>

#include "fit/reflectance/shading_scene_table.h"

namespace penumbra {

ShadingScenes referenceScenes() {
    ShadingScenes scenes;
    auto part = kSceneParts.begin();
    for (int count : kScenePartCounts) {
        scenes.occluders.emplace_back(part, part + count);
        part += count;
    }
    scenes.views.assign(kSceneViews.begin(), kSceneViews.end());
    for (const auto& light : kSceneLights) scenes.lights.emplace_back(light.begin(), light.end());
    return scenes;
}

bool isBlocked(const std::vector<OccluderPart>& parts, Vec3d direction) {
    return std::any_of(parts.begin(), parts.end(), [&](const OccluderPart& part) {
        const double along = dot(direction, part.direction);
        return part.kind == OccluderPart::kWall ? along < 0 : along > part.cosine;
    });
}

}  // namespace penumbra
