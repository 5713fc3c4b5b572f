#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "formats/stage/lobe_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Returns the visibility of a pose in the local frames, [V, order^2], in convention B.
std::vector<float> predictLobeNumbers(const LobeModel& model, std::span<const float> pose, int threads);

// Throws InvalidInput when the poses are those of another character than the model's.
void checkCharacter(const LobeModel& model, const VisibilityHeader& header, const std::string& file);

struct LobePrediction {
    std::filesystem::path output;
    Provenance provenance;
    int threads = 0;
};
// Predicts every pose of a file that passed checkCharacter(), in the layout of a bake. `progress` is told the number of
// frames done; it may be empty.
void predictLobeFile(const LobeModel& model, const VisibilityReader& poses, const LobePrediction& to,
                     const std::function<void(double)>& progress);

}  // namespace penumbra
