#pragma once
// The materials that come with the player: share/penumbra/materials.pnb beside the folder of the program, which the
// build makes (scripts/samples/make_materials).
#include <filesystem>
#include <optional>

#include "player/view/view_scene.h"

namespace penumbra {

// Returns the file, or nothing where it is not installed or the scene has it already.
std::optional<std::filesystem::path> libraryToOpen(const Scene& scene);

}  // namespace penumbra
