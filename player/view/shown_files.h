#pragma once
// Finds which of the files of a scene stay when somebody leaves it.
#include <filesystem>
#include <span>
#include <vector>

#include "player/view/view_scene.h"

namespace penumbra {

// Tells whether a character can be taken away: one that no scene.json names, and who is not the last.
bool canLeave(const Scene& scene, std::size_t character);

// Returns the files without that of a character, and without truth that fitted nobody else. `files` are those that the
// scene was opened from.
std::vector<std::filesystem::path> filesWithout(const Scene& scene, std::span<const std::filesystem::path> files,
                                                std::size_t character);

// Returns the files without characters, their truth and their scene.json. Materials and lights stay.
std::vector<std::filesystem::path> filesWithoutAnyone(const Scene& scene, std::span<const std::filesystem::path> files);

}  // namespace penumbra
