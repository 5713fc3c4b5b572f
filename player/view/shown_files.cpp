#include "player/view/shown_files.h"

#include <algorithm>

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

}  // namespace penumbra
