#include "player/papers/cast_way.h"

#include <stdexcept>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::string_view kCastModeNames[kCastModes] = {"product", "folded", "sphere-product", "hemisphere-share"};

}  // namespace

CastWay parseCastWay(std::string_view mode, std::string_view exponential) {
    CastWay way;
    std::size_t m = 0;
    while (m < kCastModes && kCastModeNames[m] != mode) ++m;
    if (m == kCastModes)
        throw UsageError("--cast must be product, folded, sphere-product or hemisphere-share, not " +
                         std::string(mode));
    way.mode = CastMode(m);
    try {
        way.exponential = parseCastExponential(exponential);
    } catch (const std::invalid_argument& error) {
        throw UsageError("--cast-exponential " + std::string(error.what()));
    }
    return way;
}

std::string_view nameOf(CastMode mode) { return kCastModeNames[std::size_t(mode)]; }

bool needsSpheres(CastMode mode) { return mode == CastMode::kSphereProduct || mode == CastMode::kHemisphereShare; }

int castOrderOf(CastMode mode) { return mode == CastMode::kSphereProduct ? 4 : kCastOrder; }

void castBySpheres(SceneDescription& scene) {
    for (std::vector<SceneCharacter>* list : {&scene.characters, &scene.props})
        for (SceneCharacter& one : *list)
            if (one.casts != SceneCasts::kNothing) one.casts = SceneCasts::kSpheres;
}

}  // namespace penumbra
