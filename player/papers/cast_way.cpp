#include "player/papers/cast_way.h"

namespace penumbra {

bool needsSpheres(CastMode mode) { return mode == CastMode::kSphereProduct || mode == CastMode::kHemisphereShare; }

int castOrderOf(CastMode mode) { return mode == CastMode::kSphereProduct ? 4 : kCastOrder; }

void castBySpheres(SceneDescription& scene) {
    for (std::vector<SceneCharacter>* list : {&scene.characters, &scene.props})
        for (SceneCharacter& one : *list)
            if (one.casts != SceneCasts::kNothing) one.casts = SceneCasts::kSpheres;
}

}  // namespace penumbra
