#include "formats/scene/scene_origin.h"

#include <cmath>

namespace penumbra {

namespace {

double nearestStep(double metres) {
    constexpr double kStep = 1024;
    return kStep * std::round(metres / kStep);
}

// `lowered` of origin.y is taken from the heights of the ground, and the rest from what they are added to.
void moveOrigin(SceneDescription& scene, Vec3d origin, double lowered) {
    scene.origin += origin;
    for (std::vector<SceneCharacter>* list : {&scene.characters, &scene.props})
        for (SceneCharacter& one : *list) {
            const double rise = one.on_ground ? 0 : origin.y;
            one.position = toFloat(toDouble(one.position) - Vec3d{origin.x, rise, origin.z});
        }
    if (!scene.ground) return;
    SceneGround& ground = *scene.ground;
    ground.center = toFloat(toDouble(ground.center) - Vec3d{origin.x, 0, origin.z});
    ground.height -= origin.y - lowered;
    if (!ground.heights) return;
    HeightSource& source = ground.heights->source;
    source.offset -= lowered;
    if (source.fill) *source.fill -= lowered;
}

}  // namespace

std::optional<GroundHeights> openGround(SceneDescription& scene) {
    std::optional<GroundHeights> heights;
    if (scene.ground && scene.ground->heights) heights.emplace(*scene.ground);
    const std::vector<SceneCharacter>& members = scene.characters.empty() ? scene.props : scene.characters;
    if (members.empty()) return heights;
    Vec3d place = toDouble(members.front().position);
    const double raised = heights ? heights->heightAt(place.x, place.z) - scene.ground->height : 0;
    if (members.front().on_ground) place.y += scene.ground->height + raised;
    const Vec3d origin{nearestStep(place.x), nearestStep(place.y), nearestStep(place.z)};
    const double lowered = nearestStep(raised);
    if (origin == Vec3d{} && lowered == 0) return heights;
    moveOrigin(scene, origin, lowered);
    if (heights) heights.emplace(*scene.ground);
    return heights;
}

}  // namespace penumbra
