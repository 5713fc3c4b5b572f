#pragma once
// One cluster: output PCA, features, a regressor of the scores, and the errors of the result by frame.
#include <span>
#include <vector>

#include "fit/models/features.h"
#include "fit/visibility/local_numbers.h"
#include "formats/stage/model_file.h"

namespace penumbra {

struct ClusterProblem {
    ModelKind kind = ModelKind::kLinear;
    const FeatureRecipe* recipe = nullptr;
    const PoseTable* poses = nullptr;
    std::span<const std::size_t> train;       // frames
    const std::vector<int>* folds = nullptr;  // of the training frames
    std::vector<float> ambient_weights;       // E = sum of weights times a vertex' numbers; empty: E is not known
    bool clamp = true;                        // predictions to where E lies in [0, 1]
    double input_variance = 0.9, output_variance = 0.95;
    int joint = 0;
    Vec3 center;  // of the cluster, rest pose
};

// Sums over the vertices of a cluster (or of all), by frame.
struct FrameErrors {
    std::vector<double> squared;   // [F] |prediction - truth|^2
    std::vector<double> variance;  // [F] |truth - training mean|^2
    std::vector<double> ambient;   // [F] |E(prediction) - E(truth)|, NaN without ambient_weights
};

struct ClusterFit {
    ClusterModel model;  // without vertices
    FrameErrors errors;
    double cross_validated = 0;  // squared error over the folds, that of the choice made
    double leave_one_out = 0;    // squared error of the kept scores; NaN for models without a closed form
    double left_by_pca = 0;      // energy of the outputs that the PCA dropped
};

// `numbers` [F, Vc n] are used up: they hold the residuals afterwards.
ClusterFit fitCluster(const ClusterProblem& problem, MatrixF& numbers);

}  // namespace penumbra
