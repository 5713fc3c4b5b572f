#pragma once
// Predicts the visibility of a pose, and of all poses of a file.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fit/models/features.h"
#include "fit/visibility/far_factors.h"
#include "fit/visibility/local_numbers.h"
#include "formats/stage/model_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct Prediction {
    std::vector<float> numbers;  // [V, n] in the model's convention and in the local frames
    double out_of_range = 0;     // model_file.h; 0 when every group is where training frames had it
};
// Predicts poses one by one. What does not change with the pose is laid out once. `model` must outlive it.
class Predictor {
public:
    explicit Predictor(const Model& model);
    // Takes the bones [J] and the pose [P] that the model sees. A composed model of a deforming mesh also needs where
    // the fronts are, [Vs] each.
    Prediction predict(std::span<const Affine> bones, std::span<const float> pose, std::span<const Vec3> positions = {},
                       std::span<const Vec3> normals = {}) const;

private:
    const Model& model_;
    FeatureRecipe recipe_;
    std::vector<float> ambient_;  // [n]
    // Only for a composed model.
    std::unique_ptr<const FarTables> far_;
    VertexSet vertices_;

    void compose(const PosedVertices& vertices, std::span<const Affine> bones, std::span<const Mat3> rotations,
                 std::span<const float> pose, std::span<float> numbers) const;
};

// Turns numbers in the local frames of a pose into what a prediction file holds, [V, order^2] in the model frame:
// hemisphere moments b for conventions A and B, coefficients of the mirrored function for D.
std::vector<float> toModelFrame(const Convention& convention, const LocalFrames& frames, std::span<const Affine> bones,
                                const std::vector<Vec3>& normals, std::span<const float> numbers, int threads);
std::vector<float> toModelFrame(const Model& model, std::span<const Affine> bones, const std::vector<Vec3>& normals,
                                std::span<const float> numbers, int threads);

// Returns the header of a file of predictions for some poses.
VisibilityHeader predictionHeader(const Convention& convention, const VisibilityHeader& poses,
                                  const Provenance& provenance);

struct PredictReport {
    std::size_t frames = 0;
    std::vector<double> out_of_range;  // [frames]
};

// Predicts every pose of a file. The result has the layout of a bake: mesh, skin, frames and poses of `poses`, with
// predicted coefficients. Throws InvalidInput when the character of `poses` is not the model's. `progress` is told the
// number of frames done; it may be empty.
struct PredictFiles {
    std::string poses;  // name of the reader's file, for messages
    std::filesystem::path output;
    Provenance provenance;
};
PredictReport predictFile(const Model& model, const VisibilityReader& poses, const PredictFiles& files, int threads,
                          const std::function<void(double)>& progress);

}  // namespace penumbra
