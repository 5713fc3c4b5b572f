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
#include "fit/visibility/local_coefficients.h"
#include "formats/stage/model_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

std::vector<int> jointsOfClusters(const Model& model);

struct Prediction {
    std::vector<float> coefficients;  // [V, n] in the model's convention and in the local frames
    double out_of_range = 0;          // model_file.h; 0 when every group is where training frames had it
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
                 std::span<const float> pose, std::span<float> coefficients) const;
};

// Turns numbers in the local frames of a pose into what a prediction file holds, [V, order^2] in the model frame:
// hemisphere moments b for conventions A and B, coefficients of the mirrored function for D.
std::vector<float> toModelFrame(const Convention& convention, const LocalFrames& frames, std::span<const Affine> bones,
                                const std::vector<Vec3>& normals, std::span<const float> coefficients, int threads);
std::vector<float> toModelFrame(const Model& model, std::span<const Affine> bones, const std::vector<Vec3>& normals,
                                std::span<const float> coefficients, int threads);

// Returns the indirect transfer of bands 0..2 in one pose, [V, 3, kIndirectCoefficients] in the model frame, as bakes
// have it. The model must have light that bounces. Takes the bones [J] and the pose [P] that the model sees, and the
// normals [V].
std::vector<float> predictIndirect(const Model& model, std::span<const Affine> bones, std::span<const float> pose,
                                   std::span<const Vec3> normals, int threads);

// Where a file of predictions goes.
struct PredictionOutput {
    std::filesystem::path file;
    Provenance provenance;
    int threads = 0;
    std::function<void(double)> progress = {};  // is told the number of frames done; may be empty
};
// Writes a file of predictions in the layout of a bake: mesh, skin, frames and poses of `poses`, with the coefficients
// that `predict` returns for each pose. They are of `order` bands, and of `quantity`.
void writePredictions(const VisibilityReader& poses, int order, const char* quantity, const PredictionOutput& to,
                      const std::function<std::vector<float>(const VisibilityFrame& pose)>& predict);
// The quantity of predictions in a convention.
const char* predictedQuantity(const Convention& convention);

// Throws InvalidInput when the poses are those of another character than the model's.
void checkCharacter(const Model& model, const VisibilityHeader& header, const std::string& file);
// Predicts every pose of a file that passed checkCharacter(). Returns Prediction::out_of_range of every frame.
std::vector<double> predictFile(const Model& model, const VisibilityReader& poses, const PredictionOutput& to);

}  // namespace penumbra
