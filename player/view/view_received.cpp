#include "player/view/view_received.h"

#include <algorithm>
#include <utility>

#include "formats/common/parallel_for.h"
#include "player/view/view_look.h"

namespace penumbra {

namespace {

void receiveFromGround(Scene& scene, const ViewState& state, const ViewKeys& keys, int threads) {
    ReceivedLight& received = scene.received;
    const SceneGround& ground = *scene.ground_file;
    received.shadows.update(keys.suns.everyone, [&](GroundGlow& glow) {
        std::vector<Vec3> corners;
        for (const auto& character : scene.characters) {
            const BoundingBox box = boundsOf(character->posed.in_scene.positions);
            corners.insert(corners.end(), {box.low, box.high});
        }
        glow.cast(*scene.cast, ground.height, corners, threads);
    });
    received.shadows->light(shownLight(scene, state), toDouble(lightRotation(state)), ground.albedo);
    for (const auto& character : scene.characters) {
        CharacterPose& posed = character->posed;
        receiveFromGround(*received.shadows, posed.hidden, threads, posed.in_scene);
        std::swap(posed.in_scene.received, posed.vertices.received);
    }
}

// Finds the light that a character sends to others: its radiance under the whole light.
void findShining(Character& character, Vec3 eye, ShiningMember& out) {
    CharacterPose& posed = character.posed;
    ShadingSet* const shading = character.shown.shading.get();
    out = {};
    if (!shading || posed.evaluator->transfer()) return;
    const bool suns = shading->sunsOn();
    if (suns) shading->setSuns(false);
    std::vector<Vec3> whole;
    const MeshView& mesh = character.asset.mesh;
    const Vec3 from = transposed(posed.to_scene.linear()) * (eye - posed.to_scene.translation());
    shadeSome(*shading, shiningVertices(mesh.positions.size(), mesh.slot_of_vertex), posed.vertices, from, whole);
    if (suns) shading->setSuns(true);
    shiningMember(posed.in_scene, mesh.triangles, whole, out);
}

void receiveFromOthers(Scene& scene, const ViewKeys& keys, int threads) {
    std::vector<ShiningMember>& shining = scene.received.shining;
    const auto receives = [](const auto& character) { return character->posed.hidden.fromOthers(); };
    if (keys.ground.seen.on_ground || std::ranges::any_of(scene.characters, receives)) {
        shining.resize(scene.characters.size());
        parallelFor(shining.size(), threads,
                    [&](std::size_t i) { findShining(*scene.characters[i], keys.received.eye, shining[i]); });
    }
    parallelFor(scene.characters.size(), threads, [&](std::size_t i) {
        CharacterPose& posed = scene.characters[i]->posed;
        if (shining.empty() || !posed.hidden.fromOthers()) return;
        posed.in_scene.received = std::move(posed.vertices.received);
        posed.in_scene.received.resize(posed.in_scene.positions.size());
        receiveFromOthers(*posed.evaluator, i, shining, posed.hidden, posed.in_scene);
        std::swap(posed.in_scene.received, posed.vertices.received);
    });
}

}  // namespace

bool updateReceived(Scene& scene, const ViewState& state, const ViewKeys& keys, int threads) {
    ReceivedLight& received = scene.received;
    return received.key.update(keys.received, [&](auto&) {
        received.version = keys.received.wanted ? ++received.latest : 0;
        received.shining.clear();
        for (const auto& character : scene.characters) character->posed.vertices.received.clear();
        if (!keys.received.wanted) return;
        if (keys.ground.seen.on_ground) receiveFromGround(scene, state, keys, threads);
        receiveFromOthers(scene, keys, threads);
    });
}

}  // namespace penumbra
