#pragma once
// Finds which of the files of a scene stay when somebody leaves it, and shows what comes with a file.
#include <filesystem>
#include <span>
#include <string>
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

// How many of each kind a scene has.
struct SceneCounts {
    std::size_t characters = 0, materials = 0, lights = 0;
    bool truth = false;
};
SceneCounts countsOf(const Scene& scene);

// Shows what has come with a file that was added to a scene of `before`: a character is selected, the light of a
// picture is on, and where truth has come the first clip that it has. Returns what to say of the file.
std::string showNewcomer(const std::filesystem::path& file, const SceneCounts& before, const Scene& scene,
                         ViewState& state);

}  // namespace penumbra
