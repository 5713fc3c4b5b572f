#pragma once
// One interface to all models of a cluster: training, and the scores that a trained model predicts for a pose.
// formats/stage/model_file.h has the formulas and says what is stored. The run-time evaluator computes the same scores.
#include <algorithm>
#include <span>
#include <vector>

#include "fit/models/features.h"
#include "fit/numerics/matrix.h"
#include "fit/numerics/pca.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// Everything that the training of one cluster reads. F counts frames, N raw features, r the components of the outputs.
struct RegressionProblem {
    const FeatureRecipe& recipe;
    ClusterPlace place;
    const Matrix& raw;                      // [F, N] raw features of all frames
    std::span<const std::size_t> train;     // the rows of `raw` to train on
    const std::vector<int>& folds;          // one fold for each training row
    std::span<const double> group_weights;  // [recipe.groups()]
    const Pca& outputs;                     // principal components of the training rows, with scores [train, r]
    std::size_t components = 0;             // K, the number of components that are kept
    double input_variance = 0.9;
    // False: as little prior as can be solved and as many units as there may be, to reproduce the training rows alone
    // (Nowrouzezahrai 2009, section 5.3). Only neural and additive models take it; nothing is cross-validated.
    bool prior = true;
};

struct RegressionErrors {
    double cross_validated = 0;  // squared error over the folds for the chosen parameters, all r components
    double leave_one_out = 0;    // squared error of the kept scores, or NaN where there is no closed form
};

// Trains a model of the given kind. Sets the fields of `model` that map raw features to scores, from feature_mean to
// bias, and ridge. The groups must already be set by setGroups(); the additive model removes those that it does not
// need.
RegressionErrors trainRegressor(ModelKind kind, const RegressionProblem& problem, ClusterModel& model);

// Sets the groups, their weights and the ranges of their inputs over the training rows. Groups with less than 0.3% of
// the largest weight are left out.
void setGroups(const RegressionProblem& problem, ClusterModel& model);

// Returns x = input_basis (raw - feature_mean), kept within its range over training frames, which is widened at both
// ends by kRangeMargin.
std::vector<float> pcaInputs(const ClusterModel& cluster, std::span<const double> raw);

struct ScoredPose {
    std::vector<float> scores;  // [K] predicted scores
    double out_of_range = 0;    // weighted squared distance of this cluster's inputs from their ranges
};
// Predicts the scores of one pose from the cluster's raw features.
ScoredPose scoreCluster(ModelKind kind, const FeatureRecipe& recipe, const ClusterModel& cluster,
                        std::span<const double> raw);

// Returns mean plus scores times basis.
std::vector<float> sumOfComponents(const ClusterModel& cluster, std::span<const float> scores);

// Copies the given rows of a matrix.
template <class T>
BasicMatrix<T> selectRows(const BasicMatrix<T>& m, std::span<const std::size_t> rows) {
    BasicMatrix<T> out(rows.size(), m.columns);
    for (std::size_t r = 0; r < rows.size(); ++r) std::copy_n(m.row(rows[r]).data(), m.columns, out.row(r).data());
    return out;
}
inline std::vector<float> toFloats(std::span<const double> values) { return {values.begin(), values.end()}; }

// Returns the first K columns of the training scores, [train, K]. Columns past the rank are zero.
Matrix keptScores(const RegressionProblem& problem);

}  // namespace penumbra
