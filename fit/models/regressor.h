#pragma once
// One interface to the models of a cluster: train, and the scores of a pose. formats/stage/model_file.h has the
// formulas and what is stored; the run-time evaluator repeats the second.
#include <algorithm>
#include <span>
#include <vector>

#include "fit/models/features.h"
#include "fit/numerics/matrix.h"
#include "fit/numerics/pca.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// What the training of one cluster sees.
struct RegressionProblem {
    const FeatureRecipe& recipe;
    ClusterPlace place;
    const Matrix& raw;                      // [F, N] of all frames
    std::span<const std::size_t> train;     // rows
    const std::vector<int>& folds;          // of the training rows
    std::span<const double> group_weights;  // [recipe.groups()]
    const Pca& outputs;                     // of the training rows: scores [train, r]
    std::size_t components = 0;             // K that are kept
    double input_variance = 0.9;
};

struct RegressionErrors {
    double cross_validated = 0;  // squared error over the folds of the choice that was made, all r components
    double leave_one_out = 0;    // squared error of the kept scores; NaN where there is no closed form
};

// Sets what maps raw features to scores: feature_mean to bias, but no groups, and ridge.
RegressionErrors trainRegressor(ModelKind kind, const RegressionProblem& problem, ClusterModel& model);

// Sets groups, their weights and their ranges over the training rows: groups of at least 0.3% of the largest weight
// that move at all.
void setGroups(const RegressionProblem& problem, ClusterModel& model);

struct ScoredPose {
    std::vector<float> scores;  // [K]
    double out_of_range = 0;    // squared, of this cluster
};
ScoredPose scoreCluster(ModelKind kind, const FeatureRecipe& recipe, const ClusterModel& cluster,
                        std::span<const double> raw);

// Of rows of a matrix.
template <class T>
BasicMatrix<T> selectRows(const BasicMatrix<T>& m, std::span<const std::size_t> rows) {
    BasicMatrix<T> out(rows.size(), m.columns);
    for (std::size_t r = 0; r < rows.size(); ++r) std::copy_n(m.row(rows[r]).data(), m.columns, out.row(r).data());
    return out;
}
inline std::vector<float> toFloats(std::span<const double> values) { return {values.begin(), values.end()}; }

// The first K columns of the training scores, [train, K]; zeros past the rank.
Matrix keptScores(const RegressionProblem& problem);

}  // namespace penumbra
