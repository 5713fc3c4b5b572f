#include "player/view/shown_files.h"

#include <algorithm>

#include "player/frame/truth_frames.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

// Returns the asset of a file; null for a picture and for a scene.json.
const AssetView* assetOf(const Scene& scene, const fs::path& path) {
    for (const SceneFile& file : scene.files) {
        std::error_code gone;  // then it is no file of the scene
        if (file.asset && fs::equivalent(file.asset->view.name, path, gone)) return &file.asset->view;
    }
    return nullptr;
}

bool isCharacter(const AssetView* asset) { return asset && asset->has_mesh && asset->hasCharacter(); }

// Tells whether the truth is of a character other than `left`.
bool servesAnother(const Scene& scene, const AssetView& truth, std::size_t left) {
    for (std::size_t i = 0; i < scene.characters.size(); ++i)
        if (i != left && scene.characters[i]->truth == &truth) return true;
    return false;
}

}  // namespace

bool canLeave(const Scene& scene, std::size_t character) {
    return scene.characters.size() > 1 && !memberOf(scene, character);
}

std::vector<fs::path> filesWithout(const Scene& scene, std::span<const fs::path> files, std::size_t character) {
    std::vector<fs::path> left;
    // Characters of a scene.json come first, and the others follow in the order of the files.
    std::size_t next = 0;
    while (memberOf(scene, next)) ++next;
    for (const fs::path& file : files) {
        const AssetView* const asset = assetOf(scene, file);
        if (isCharacter(asset) && next++ == character) continue;
        if (asset && asset->has_truth && !servesAnother(scene, *asset, character)) continue;
        left.push_back(file);
    }
    return left;
}

std::vector<fs::path> filesWithoutAnyone(const Scene& scene, std::span<const fs::path> files) {
    std::vector<fs::path> left;
    std::ranges::copy_if(files, std::back_inserter(left), [&](const fs::path& file) {
        const AssetView* const asset = assetOf(scene, file);
        return file.extension() != ".json" && !isCharacter(asset) && !(asset && asset->has_truth);
    });
    return left;
}

SceneCounts countsOf(const Scene& scene) {
    return {scene.characters.size(), scene.material_names.size(), scene.light_names.size(), scene.hasTruth()};
}

namespace {

// Chooses the selected character's first clip with truth, unless its clip has some.
void showClipWithTruth(const Scene& scene, ViewState& state) {
    const Character& character = *scene.characters[state.selected];
    if (!character.truth || hasTruthOf(character.asset, *character.truth, selectedClip(state, scene))) return;
    const std::vector<ClipView>& clips = character.asset.animation.clips;
    for (std::size_t i = 0; i < clips.size(); ++i)
        if (hasTruthOf(character.asset, *character.truth, clips[i])) return chooseClip(state, i);
}

std::string counted(std::size_t count, const std::string& what, const std::string& key) {
    if (count == 0) return "";
    return ", " + std::to_string(count) + " " + what + (count > 1 ? "s" : "") + " more (" + key + ")";
}

}  // namespace

std::string showNewcomer(const fs::path& file, const SceneCounts& before, const Scene& scene, ViewState& state) {
    const SceneCounts now = countsOf(scene);
    const std::string opened = "opened " + file.filename().string();
    if (file.extension() == ".exr" || file.extension() == ".hdr") {
        const auto found = std::ranges::find(scene.light_names, file.filename().string());
        if (found == scene.light_names.end()) return opened;
        state.lighting.light = std::size_t(found - scene.light_names.begin());
        return opened + ": it is the light now (L goes through all lights)";
    }
    if (now.characters > before.characters) {
        state.selected = now.characters - 1;
        return opened + ": its clips are listed now";
    }
    if (now.truth && !before.truth) {
        showClipWithTruth(scene, state);
        return opened + ": 3 shows the error against it, T the truth itself";
    }
    return opened + counted(now.materials - std::min(now.materials, before.materials), "material", "M") +
           counted(now.lights - std::min(now.lights, before.lights), "light", "L");
}

}  // namespace penumbra
