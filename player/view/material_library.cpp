#include "player/view/material_library.h"

#include <algorithm>

namespace penumbra {

namespace {

// Returns an empty path where the file is not installed.
std::filesystem::path installedLibrary() {
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::filesystem::path file = program.parent_path().parent_path() / "share/penumbra/materials.pnb";
    return std::filesystem::exists(file, error) ? file : std::filesystem::path();
}

}  // namespace

std::optional<std::filesystem::path> libraryToOpen(const Scene& scene) {
    static const std::string library = installedLibrary().string();
    const auto is_library = [](const SceneFile& file) { return file.asset && file.asset->view.name == library; };
    if (library.empty() || std::ranges::any_of(scene.files, is_library)) return std::nullopt;
    return library;
}

}  // namespace penumbra
