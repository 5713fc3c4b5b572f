#pragma once
// Fits one cluster: output PCA, features, a model of the scores, and the errors of the result frame by frame.
#include <span>
#include <vector>

#include "fit/models/features.h"
#include "fit/visibility/error_figures.h"
#include "fit/visibility/local_coefficients.h"
#include "formats/stage/model_file.h"

namespace penumbra {

struct ClusterProblem {
    ModelKind kind = ModelKind::kLinear;
    const FeatureRecipe* recipe = nullptr;
    const PoseTable* poses = nullptr;
    std::span<const std::size_t> train;       // training frames
    const std::vector<int>* folds = nullptr;  // one for each training frame
    std::vector<float> ambient_weights;  // E is the sum of these times a vertex' numbers; empty when E is not known
    bool clamp = true;                   // moves predictions to where E lies in [0, 1]
    double input_variance = 0.9, output_variance = 0.95;
    int joint = 0;
    Vec3 center;        // center of the cluster in the rest pose
    bool prior = true;  // RegressionProblem::prior
};

struct ClusterFit {
    ClusterModel model;  // all but its vertices
    FrameErrors errors;
    double cross_validated = 0;  // squared error over the folds, for the parameters that were chosen
    double leave_one_out = 0;    // squared error of the kept scores; NaN for models without a closed form
    double left_by_pca = 0;      // energy of the outputs that the output PCA dropped
};

// Returns the raw features of a cluster of this joint in every frame, [F, N].
Matrix rawFeatures(const FeatureRecipe& recipe, int joint, const PoseTable& poses);

// Sets the relative squared errors of a cluster over training frames and over all other frames.
void setErrorRatios(const FrameErrors& errors, std::span<const std::size_t> train, ClusterModel& model);

// Fits the cluster to `coefficients` [F, Vc n]. They are used up: afterwards they hold the residuals.
ClusterFit fitCluster(const ClusterProblem& problem, MatrixF& coefficients);

}  // namespace penumbra
