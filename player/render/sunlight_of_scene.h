#pragma once
// Makes what draws the suns of a scene.
#include <optional>

#include "player/draw/sunlight.h"
#include "player/frame/sky_picture.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Returns the suns of `frames`, SceneFrames or SceneOnGpu, with the sky that mirrors reflect and without maps. Nothing
// where none shines. `frames` outlives the result.
template <class Frames>
std::optional<Sunlight> sunlightOf(const PosedScene& scene, const Frames& frames, int map_size) {
    std::optional<Sunlight> suns;
    if (frames.suns().empty()) return suns;
    suns.emplace(frames.lobes(), map_size);
    suns->reflect(skyPicture(*scene.light()));
    suns->turnSky(frames.lightRotation());
    return suns;
}

}  // namespace penumbra
