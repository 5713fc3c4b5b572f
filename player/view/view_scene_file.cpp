// Takes over what a scene.json says.
#include <algorithm>

#include "formats/scene/scene_camera.h"
#include "formats/scene/scene_placement.h"
#include "player/view/view_scene.h"

namespace penumbra {

namespace {

// Returns which of the scene's lights is the file's.
std::size_t lightOfFile(const Scene& scene) {
    const SceneLight& wanted = scene.file->light;
    const std::filesystem::path path =
        wanted.asset.empty() ? scene.characters.front()->asset.name : wanted.asset.string();
    std::size_t first = 0;
    for (const SceneFile& file : scene.files) {
        if (file.asset && std::filesystem::equivalent(path, file.asset->view.name)) {
            const LightView* light = lightOf(wanted, file.asset->view);
            return light ? first + std::size_t(light - file.asset->view.lights.data()) : 0;
        }
        first += file.asset ? file.asset->view.lights.size() : 1;
    }
    return 0;
}

// Returns the material of each slot. Names are those of the member's own file, if that has any materials.
std::vector<std::size_t> lookOf(const Scene& scene, const SceneCharacter& one, const Character& character) {
    const std::size_t slots = std::max<std::size_t>(1, character.asset.mesh.slots.size());
    std::size_t first = 0;
    for (const SceneFile& file : scene.files) {
        if (!file.asset) continue;
        const std::vector<MaterialView>& own = file.asset->view.materials;
        if (file.asset->view.name == character.asset.name && !own.empty()) {
            std::vector<std::size_t> materials = materialsOf(one, file.asset->view);
            for (std::size_t& material : materials) material += first;
            return materials;
        }
        first += own.size();
    }
    if (character.asset.materials.empty()) return std::vector<std::size_t>(slots);
    return materialsOf(one, character.asset);
}

}  // namespace

const SceneCharacter* memberOf(const Scene& scene, std::size_t i) {
    if (!scene.file) return nullptr;
    const std::size_t people = scene.file->characters.size();
    if (i < people) return &scene.file->characters[i];
    return i < people + scene.file->props.size() ? &scene.file->props[i - people] : nullptr;
}

void applySceneFile(const Scene& scene, ViewState& state) {
    if (!scene.file) return;
    for (std::size_t i = 0; const SceneCharacter* member = memberOf(scene, i); ++i) {
        const SceneCharacter& one = *member;
        const Character& character = *scene.characters[i];
        const AnimationView& animation = character.asset.animation;
        const std::size_t frame = frameOf(one, animation, {});
        CharacterChoice& choice = state.characters[i];
        choice = {};
        while (frame >= animation.clips[choice.clip].first_frame + animation.clips[choice.clip].frame_count)
            ++choice.clip;
        const ClipView& clip = animation.clips[choice.clip];
        choice.start = frameSeconds(animation, clip, frame - clip.first_frame);  // the time that render shows
        choice.still = i >= scene.file->characters.size() || one.pose;
        choice.material_of_slot = lookOf(scene, one, character);
    }
    state.playhead.time = 0;
    state.lighting.light = lightOfFile(scene);
    const Mat3d rotation = rotationOf(scene.file->light);
    for (std::size_t i = 0; i < 9; ++i) state.lighting.base.m[i] = float(rotation.m[i]);
    state.lighting.yaw = state.lighting.pitch = 0;
    state.show.ground = scene.file->ground.has_value();
    const BoundingBox box = restBounds(scene);
    const std::array points = {box.low, box.high};
    if (scene.file->photograph) {
        const SceneView view = SceneCameras(*scene.file).view(0, scene.file->origin);
        const Vec3d middle = toDouble(box.low + box.high) * 0.5;
        state.camera = orbitLike(view, std::max(length(middle - view.eye()), 1e-3));
        state.frame_all = false;
        return;
    }
    state.camera = cameraOf(*scene.file, "", points);
    // The camera frames all members if the file says nothing, as soon as everyone has their pose.
    const std::string& text = scene.file->camera;
    state.frame_all = text.find("target") == text.npos && text.find("distance") == text.npos;
}

}  // namespace penumbra
