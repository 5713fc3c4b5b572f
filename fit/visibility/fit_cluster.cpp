#include "fit/visibility/fit_cluster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fit/models/regressor.h"
#include "fit/numerics/eigen_map.h"
#include "fit/numerics/pca.h"

namespace penumbra {

namespace {

template <class T>
void subtractFromRows(BasicMatrix<T>& m, std::span<const T> mean) {
    for (std::size_t r = 0; r < m.rows; ++r)
        for (std::size_t c = 0; c < m.columns; ++c) m(r, c) -= mean[c];
}

// Turns truth - mean into truth - prediction, row by row.
void subtractPrediction(const ClusterProblem& problem, const ClusterModel& model, const Matrix& raw,
                        MatrixF& residual) {
    const std::vector<float>& w = problem.ambient_weights;
    const float norm2 = std::inner_product(w.begin(), w.end(), w.begin(), 0.0f);
    const Eigen::Map<const EigenRows<float>> basis(model.basis.data(), Eigen::Index(model.components()),
                                                   Eigen::Index(residual.columns));
    // A batch of frames reads the basis once.
    constexpr std::size_t kBatch = 16;
    for (std::size_t first = 0; first < raw.rows; first += kBatch) {
        const std::size_t frames = std::min(kBatch, raw.rows - first);
        MatrixF scores(frames, model.components()), coefficients(frames, residual.columns);
        for (std::size_t f = 0; f < frames; ++f) {
            const std::vector<float> of_frame =
                scoreCluster(problem.kind, *problem.recipe, model, raw.row(first + f)).scores;
            std::copy(of_frame.begin(), of_frame.end(), scores.row(f).begin());
        }
        asEigen(coefficients).noalias() = asEigen(scores) * basis;
        for (std::size_t f = 0; f < frames; ++f) {
            const std::span<float> row = coefficients.row(f), left = residual.row(first + f);
            for (std::size_t c = 0; c < row.size(); ++c) row[c] += model.mean[c];
            for (std::size_t c = 0; c < row.size() && problem.clamp; c += w.size())
                clampAmbient(w, norm2, row.subspan(c, w.size()));
            for (std::size_t c = 0; c < row.size(); ++c) left[c] -= row[c] - model.mean[c];
        }
    }
}

std::vector<double> squaredNorms(const MatrixF& m) {
    std::vector<double> sums(m.rows);
    for (std::size_t f = 0; f < m.rows; ++f)
        for (float x : m.row(f)) sums[f] += double(x) * x;
    return sums;
}

// Returns the sum over vertices of |E(prediction) - E(truth)| for every frame.
std::vector<double> ambientErrors(const std::vector<float>& w, const MatrixF& residual) {
    if (w.empty()) return std::vector<double>(residual.rows, std::numeric_limits<double>::quiet_NaN());
    std::vector<double> sums(residual.rows);
    for (std::size_t f = 0; f < residual.rows; ++f)
        for (std::size_t c = 0; c < residual.columns; c += w.size()) {
            double e = 0;
            for (std::size_t i = 0; i < w.size(); ++i) e += double(w[i]) * residual(f, c + i);
            sums[f] += std::abs(e);
        }
    return sums;
}

}  // namespace

Matrix rawFeatures(const FeatureRecipe& recipe, int joint, const PoseTable& poses) {
    Matrix raw(poses.frameCount(), recipe.count());
    for (std::size_t f = 0; f < raw.rows; ++f)
        rawFeatures(recipe, joint, poses.bonesOf(f), poses.rotationsOf(f), poses.poseOf(f), raw.row(f));
    return raw;
}

void setErrorRatios(const FrameErrors& errors, std::span<const std::size_t> train, ClusterModel& model) {
    double squared[2] = {}, variance[2] = {};
    std::vector<bool> trained(errors.squared.size());
    for (std::size_t f : train) trained[f] = true;
    for (std::size_t f = 0; f < trained.size(); ++f) {
        squared[trained[f]] += errors.squared[f];
        variance[trained[f]] += errors.variance[f];
    }
    const auto ratio = [&](bool t) { return variance[t] > 0 ? squared[t] / variance[t] : 0.0; };
    model.train_error = ratio(true);
    model.holdout_error = train.size() == trained.size() ? std::numeric_limits<double>::quiet_NaN() : ratio(false);
}

ClusterFit fitCluster(const ClusterProblem& problem, MatrixF& coefficients) {
    // 1. Take the training mean off the numbers.
    ClusterFit fit;
    fit.model.joint = problem.joint;
    fit.model.center = problem.center;
    fit.model.mean = toFloats(meanOfRows(coefficients, problem.train));
    subtractFromRows(coefficients, std::span<const float>(fit.model.mean));
    fit.errors.variance = squaredNorms(coefficients);

    // 2. Reduce the outputs by PCA over the training frames.
    const MatrixF centered = selectRows(coefficients, problem.train);
    const Pca outputs = principalComponents(centered);
    const std::size_t components = componentsFor(outputs, problem.output_variance);
    fit.model.basis = basisOf(outputs, centered, components).values;
    for (std::size_t k = components; k < outputs.energies.size(); ++k) fit.left_by_pca += outputs.energies[k];

    // 3. Compute the features, and train a model of the scores.
    const Matrix raw = rawFeatures(*problem.recipe, problem.joint, *problem.poses);
    const ClusterPlace place{problem.joint, problem.center};
    const std::vector<double> group_weights = groupWeights(*problem.recipe, place, raw, problem.train);
    const RegressionProblem regression{*problem.recipe, place,   raw,        problem.train,          *problem.folds,
                                       group_weights,   outputs, components, problem.input_variance, problem.prior};
    setGroups(regression, fit.model);
    const RegressionErrors errors = trainRegressor(problem.kind, regression, fit.model);
    fit.cross_validated = errors.cross_validated;
    fit.leave_one_out = errors.leave_one_out;

    // 4. Measure the errors of the predictions.
    subtractPrediction(problem, fit.model, raw, coefficients);
    fit.errors.squared = squaredNorms(coefficients);
    fit.errors.ambient = ambientErrors(problem.ambient_weights, coefficients);
    setErrorRatios(fit.errors, problem.train, fit.model);
    return fit;
}

}  // namespace penumbra
