#include "fit/fit_cluster.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/cross_validation.h"
#include "fit/eigen_map.h"
#include "fit/linear_model.h"
#include "fit/pca.h"

namespace penumbra {

namespace {

constexpr double kLeastAlphaExponent = -5, kMostAlphaExponent = 1.5, kAlphaExponentStep = 0.25;

// alpha as a multiple of the largest singular value of the inputs: from no prior to nearly the mean alone.
std::vector<double> alphaGrid(double largest_singular_value) {
    std::vector<double> alphas;
    for (double e = kLeastAlphaExponent; e <= kMostAlphaExponent; e += kAlphaExponentStep)
        alphas.push_back(std::pow(10.0, e) * std::max(largest_singular_value, 1e-12));
    return alphas;
}

template <class T>
BasicMatrix<T> selectRows(const BasicMatrix<T>& m, std::span<const std::size_t> rows) {
    BasicMatrix<T> out(rows.size(), m.columns);
    for (std::size_t r = 0; r < rows.size(); ++r) std::copy_n(m.row(rows[r]).data(), m.columns, out.row(r).data());
    return out;
}

std::vector<float> toFloats(std::span<const double> values) { return {values.begin(), values.end()}; }

template <class T>
void subtractFromRows(BasicMatrix<T>& m, std::span<const T> mean) {
    for (std::size_t r = 0; r < m.rows; ++r)
        for (std::size_t c = 0; c < m.columns; ++c) m(r, c) -= mean[c];
}

Matrix allRawFeatures(const ClusterProblem& problem) {
    Matrix raw(problem.poses->frameCount(), problem.recipe->count());
    for (std::size_t f = 0; f < raw.rows; ++f)
        rawFeatures(*problem.recipe, problem.joint, problem.poses->bonesOf(f), problem.poses->rotationsOf(f),
                    problem.poses->poseOf(f), raw.row(f));
    return raw;
}

// Raw features times their weights, centred on the training frames; training rows only.
Matrix weightedInputs(const Matrix& raw, std::span<const std::size_t> train, std::span<const double> mean,
                      std::span<const double> weights) {
    Matrix x = selectRows(raw, train);
    for (std::size_t r = 0; r < x.rows; ++r)
        for (std::size_t c = 0; c < x.columns; ++c) x(r, c) = (x(r, c) - mean[c]) * weights[c];
    return x;
}

// Feature recipe of the model: mean, and the PCA rows with the weights multiplied in. Returns the training inputs.
Matrix setInputs(ClusterModel& model, const Matrix& weighted, const Pca& pca, std::size_t count,
                 std::span<const double> mean, std::span<const double> weights) {
    model.feature_mean = toFloats(mean);
    const Matrix basis = basisOf(pca, weighted, count);
    model.input_basis.clear();
    for (std::size_t i = 0; i < basis.rows; ++i)
        for (std::size_t c = 0; c < basis.columns; ++c) model.input_basis.push_back(float(basis(i, c) * weights[c]));
    Matrix x(weighted.rows, count);
    asEigen(x) = asEigen(weighted) * asEigen(basis).transpose();
    const Eigen::RowVectorXd least = asEigen(x).colwise().minCoeff(), most = asEigen(x).colwise().maxCoeff();
    model.input_min = toFloats({least.data(), std::size_t(least.size())});
    model.input_max = toFloats({most.data(), std::size_t(most.size())});
    return x;
}

void setRegression(ClusterFit& fit, const Matrix& x, const Matrix& y, double alpha) {
    const Ridge ridge = fitRidge(x, y, alpha);
    fit.model.ridge = alpha;
    fit.model.bias = toFloats(ridge.intercept);
    for (std::size_t k = 0; k < y.columns; ++k)
        for (std::size_t i = 0; i < x.columns; ++i) fit.model.weights.push_back(float(ridge.weights(i, k)));
    const double loo = leaveOneOutError(ridge, x, y);
    fit.leave_one_out = loo * loo * double(y.values.size());
}

double chooseAlpha(ClusterFit& fit, const ClusterProblem& problem, const Matrix& weighted, const Pca& inputs,
                   const Pca& outputs) {
    const std::vector<double> alphas = alphaGrid(inputs.energies.empty() ? 0 : std::sqrt(inputs.energies[0]));
    const std::vector<double> errors =
        blockedErrors(weighted, outputs.scores, *problem.folds, problem.input_variance, alphas);
    // Of equal errors the strongest prior: with nothing to validate on, that is nearly the mean alone.
    std::size_t best = 0;
    for (std::size_t a = 1; a < errors.size(); ++a)
        if (errors[a] <= errors[best]) best = a;
    fit.cross_validated = errors[best];
    return alphas[best];
}

// `residual` is truth minus training mean on entry, minus the prediction on return.
void subtractPrediction(const ClusterModel& model, const Matrix& raw, MatrixF& residual) {
    MatrixF scores(raw.rows, model.bias.size());
    for (std::size_t f = 0; f < raw.rows; ++f) {
        const std::vector<float> y = clusterScores(model, raw.row(f), {});
        std::copy(y.begin(), y.end(), scores.row(f).begin());
    }
    const Eigen::Map<const EigenRows<float>> basis(model.basis.data(), Eigen::Index(model.bias.size()),
                                                   Eigen::Index(residual.columns));
    asEigen(residual).noalias() -= asEigen(scores) * basis;
}

std::vector<double> squaredNorms(const MatrixF& m) {
    std::vector<double> sums(m.rows);
    for (std::size_t f = 0; f < m.rows; ++f)
        for (float x : m.row(f)) sums[f] += double(x) * x;
    return sums;
}

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

void setErrorRatios(ClusterFit& fit, std::span<const std::size_t> train) {
    double squared[2] = {}, variance[2] = {};
    std::vector<bool> trained(fit.errors.squared.size());
    for (std::size_t f : train) trained[f] = true;
    for (std::size_t f = 0; f < trained.size(); ++f) {
        squared[trained[f]] += fit.errors.squared[f];
        variance[trained[f]] += fit.errors.variance[f];
    }
    const auto ratio = [&](bool t) { return variance[t] > 0 ? squared[t] / variance[t] : 0.0; };
    fit.model.train_error = ratio(true);
    fit.model.holdout_error = train.size() == trained.size() ? std::numeric_limits<double>::quiet_NaN() : ratio(false);
}

}  // namespace

std::vector<float> clusterScores(const ClusterModel& cluster, std::span<const double> raw, std::span<float> inputs) {
    const std::size_t n = raw.size(), input_count = std::size_t(cluster.inputs());
    std::vector<double> x(input_count);
    for (std::size_t i = 0; i < input_count; ++i)
        for (std::size_t c = 0; c < n; ++c)
            x[i] += double(cluster.input_basis[i * n + c]) * (raw[c] - double(cluster.feature_mean[c]));
    for (std::size_t i = 0; i < inputs.size(); ++i) inputs[i] = float(x[i]);
    std::vector<float> y;
    for (std::size_t k = 0; k < cluster.bias.size(); ++k) {
        double sum = cluster.bias[k];
        for (std::size_t i = 0; i < input_count; ++i) sum += double(cluster.weights[k * input_count + i]) * x[i];
        y.push_back(float(sum));
    }
    return y;
}

ClusterFit fitCluster(const ClusterProblem& problem, MatrixF& numbers) {
    ClusterFit fit;
    fit.model.joint = problem.joint;
    fit.model.mean = toFloats(meanOfRows(numbers, problem.train));
    subtractFromRows(numbers, std::span<const float>(fit.model.mean));
    fit.errors.variance = squaredNorms(numbers);

    const MatrixF centred = selectRows(numbers, problem.train);
    const Pca outputs = principalComponents(centred);
    const std::size_t components = componentsFor(outputs, problem.output_variance);
    fit.model.basis = basisOf(outputs, centred, components).values;
    for (std::size_t k = components; k < outputs.energies.size(); ++k) fit.left_by_pca += outputs.energies[k];

    const Matrix raw = allRawFeatures(problem);
    const std::vector<double> mean = meanOfRows(raw, problem.train);
    const std::vector<double> weights =
        featureWeights(*problem.recipe, problem.joint, problem.center, raw, problem.train);
    const Matrix weighted = weightedInputs(raw, problem.train, mean, weights);
    const Pca inputs = principalComponents(weighted);
    const double alpha = chooseAlpha(fit, problem, weighted, inputs, outputs);
    const Matrix x =
        setInputs(fit.model, weighted, inputs, componentsFor(inputs, problem.input_variance), mean, weights);

    Matrix y(x.rows, components);
    const auto known = Eigen::Index(std::min(components, outputs.energies.size()));
    asEigen(y).leftCols(known) = asEigen(outputs.scores).leftCols(known);
    setRegression(fit, x, y, alpha);

    subtractPrediction(fit.model, raw, numbers);
    fit.errors.squared = squaredNorms(numbers);
    fit.errors.ambient = ambientErrors(problem.ambient_weights, numbers);
    setErrorRatios(fit, problem.train);
    return fit;
}

}  // namespace penumbra
