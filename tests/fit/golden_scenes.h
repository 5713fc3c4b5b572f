#pragma once
// The scenes of tests/golden/scene_seed*.json. Those of seed 11 are also constants of the program. Those of seed 12 are
// not, and nothing was tuned on them.
#include "fit/reflectance/shading_scenes.h"
#include "tests/sh/golden.h"

namespace penumbra {

inline ShadingScenes scenesOfGolden(const nlohmann::json& golden) {
    ShadingScenes scenes;
    for (const auto& occluder : golden.at("occluders")) {
        auto& parts = scenes.occluders.emplace_back();
        for (const auto& part : occluder.at("parts")) {
            const bool wall = part.at(0) == "wall";
            parts.push_back({wall ? OccluderPart::kWall : OccluderPart::kCap, Vec3d{part.at(1), part.at(2), part.at(3)},
                             wall ? 0 : part.at(4).get<double>()});
        }
    }
    for (const auto& view : golden.at("views")) scenes.views.push_back(vec3(view));
    for (const auto& light : golden.at("lights")) scenes.lights.push_back(doubles(light));
    return scenes;
}

}  // namespace penumbra
