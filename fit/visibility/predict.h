#pragma once
// Predicted visibility of a pose, and of all poses of a file.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "formats/stage/model_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct Prediction {
    std::vector<float> numbers;  // [V, n] of the model's convention, local frames
    double out_of_range = 0;     // model_file.h; 0: every group is where training frames had it
};
Prediction predictNumbers(const Model& model, std::span<const Affine> bones, std::span<const float> pose);

// Numbers in the local frames of the pose -> what a prediction file holds, [V, order^2] in the model frame: hemisphere
// moments b for conventions A and B, coefficients of the mirrored function for D.
std::vector<float> toModelFrame(const Model& model, std::span<const Affine> bones, const std::vector<Vec3>& normals,
                                std::span<const float> numbers, int threads);

struct PredictReport {
    std::size_t frames = 0;
    std::vector<double> out_of_range;  // [frames]
};

// The layout of a bake: mesh, skin, frames and poses of `poses`, coefficients predicted. InvalidInput when the
// character of `poses` is not the model's. `progress` gets the number of frames done; may be empty.
struct PredictFiles {
    std::string poses;  // name of the reader's file, for messages
    std::filesystem::path output;
    Provenance provenance;
};
PredictReport predictFile(const Model& model, const VisibilityReader& poses, const PredictFiles& files, int threads,
                          const std::function<void(double)>& progress);

}  // namespace penumbra
