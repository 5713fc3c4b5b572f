#pragma once
// Measures what a frame of a scene costs where the GPU evaluates, casts and shades.
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "player/frame/render_options.h"
#include "player/gl/offscreen_target.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Medians in milliseconds. evaluate: upload of the poses, casting, visibility and shading; maps: those of all suns.
struct SceneGpuSteps {
    double evaluate = 0, maps = 0, draw = 0;
    double all() const { return evaluate + maps + draw; }
};

struct SceneGpuCost {
    SceneGpuSteps until_done;  // until glFinish returns, with the driver's work and the way there and back
    SceneGpuSteps gpu;         // times that the GPU itself worked, by time stamps; wrong in software (GpuTimer)
};

// Measures `runs` frames, drawn into a target of the options' size. Unset where the GPU cannot evaluate the scene
// (fitsGpu(), or it is too large).
std::optional<SceneGpuCost> measureSceneGpuCost(const PosedScene& scene, const RenderOptions& options, int threads,
                                                int runs);

nlohmann::ordered_json figuresOf(const SceneGpuCost& cost);

}  // namespace penumbra
