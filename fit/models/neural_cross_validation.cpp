#include "fit/models/neural_cross_validation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "fit/models/neural_start.h"
#include "fit/models/variable_projection.h"
#include "fit/numerics/cross_validation.h"
#include "fit/numerics/eigen_map.h"
#include "fit/numerics/pca.h"

namespace penumbra {

namespace {

// These options limit how far a search goes. Deeper searches fit the training frames better, but not new clips: the
// relative error on two held-out clips is 0.664 both for 1e-3 with 200 iterations and for 1e-4 with 400 (31 clusters,
// 199 frames, 32 neurons).
const SearchOptions kValidation{.iterations = 200, .least_decrease = 1e-3};
const SearchOptions kFinal{.iterations = 500, .least_decrease = 1e-4};
constexpr double kTolerated = 1.01;  // error that a smaller net may have, as a multiple of the best

// Returns 1 / (root mean square length of the rows), or 1 when all rows are zero.
double scaleOf(const Matrix& m) {
    const double square = asEigen(m).squaredNorm() / double(m.rows);
    return square > 0 ? 1 / std::sqrt(square) : 1;
}

Matrix scaled(const Matrix& m, double factor) {
    Matrix out = m;
    asEigen(out) *= factor;
    return out;
}

// The data of one fold: what a net is fitted to and what it is judged by.
struct NetFold {
    Matrix x, y;          // kept rows, scaled
    Matrix x_out, y_out;  // left out, in the same units
    double output_scale;
    NetData data;  // x and y as the fit reads them
};

// Merges folds until `count` are left.
std::vector<int> mergeFolds(const std::vector<int>& folds, int count) {
    std::vector<std::size_t> size(folds.empty() ? 0 : std::size_t(1 + *std::max_element(folds.begin(), folds.end())));
    for (int f : folds) ++size[std::size_t(f)];
    const std::vector<int> group = dealOut(size, std::min(size.size(), std::size_t(count)));
    std::vector<int> merged;
    for (int f : folds) merged.push_back(group[std::size_t(f)]);
    return merged;
}

// Makes the data of the fold `left_out`. Means, input PCA and scales come from the kept rows alone.
NetFold makeFold(const Matrix& inputs, const Matrix& outputs, const std::vector<int>& folds, int left_out,
                 double input_variance) {
    std::vector<std::size_t> kept, out;
    for (std::size_t i = 0; i < folds.size(); ++i) (folds[i] == left_out ? out : kept).push_back(i);
    const std::vector<double> x_mean = meanOfRows(inputs, kept), y_mean = meanOfRows(outputs, kept);
    // 1. Reduce the inputs by the PCA of the kept rows.
    NetFold fold;
    const Matrix centered = centeredRows(inputs, kept, x_mean);
    const Pca pca = principalComponents(centered);
    const Matrix basis = basisOf(pca, centered, componentsFor(pca, input_variance));
    fold.x = Matrix(kept.size(), basis.rows);
    fold.x_out = Matrix(out.size(), basis.rows);
    asEigen(fold.x).noalias() = asEigen(centered) * asEigen(basis).transpose();
    asEigen(fold.x_out).noalias() = asEigen(centeredRows(inputs, out, x_mean)) * asEigen(basis).transpose();
    // 2. Center the outputs by the means of the kept rows.
    fold.y = centeredRows(outputs, kept, y_mean);
    fold.y_out = centeredRows(outputs, out, y_mean);
    // 3. Scale both to a root mean square length of 1.
    const double input_scale = scaleOf(fold.x);
    fold.output_scale = scaleOf(fold.y);
    for (Matrix* m : {&fold.x, &fold.x_out}) asEigen(*m) *= input_scale;
    for (Matrix* m : {&fold.y, &fold.y_out}) asEigen(*m) *= fold.output_scale;
    fold.data = netData(fold.x, fold.y);
    return fold;
}

// Continues the search from `net` with the weight `prior`, and returns the squared error of the result on the fold.
double advance(const NetFold& fold, double prior, TanhNet& net) {
    net = fitByProjection(fold.data, net, prior * double(fold.x.rows), kValidation).net;
    const double error = (asEigen(predict(net, fold.x_out)) - asEigen(fold.y_out)).squaredNorm();
    return error / (fold.output_scale * fold.output_scale);
}

// Returns one net for each fold to start the search from.
std::vector<TanhNet> startNets(const std::vector<NetFold>& folds, std::size_t neurons, std::uint64_t seed) {
    std::vector<TanhNet> nets;
    for (const NetFold& fold : folds) nets.push_back(startNet(fold.x, fold.y, neurons, seed));
    return nets;
}

// Continues the search of every fold and returns the sum of the errors.
double advanceAll(const std::vector<NetFold>& folds, double prior, std::vector<TanhNet>& nets) {
    double error = 0;
    for (std::size_t f = 0; f < folds.size(); ++f) error += advance(folds[f], prior, nets[f]);
    return error;
}

// Tries the priors from the least upwards, until the error has risen twice in a row. Each search starts from the end of
// the last. The other way round would be worse: a strong prior leaves dead neurons, which would never come back.
NetChoice choosePrior(const std::vector<NetFold>& folds, const NetSearch& search) {
    NetChoice best{search.neurons.front(), search.most_prior, std::numeric_limits<double>::infinity()};
    std::vector<TanhNet> nets = startNets(folds, best.neurons, search.seed);
    int risen = 0;
    for (double prior = search.least_prior; prior <= search.most_prior && risen < 2; prior *= search.prior_ratio) {
        const double error = advanceAll(folds, prior, nets);
        risen = error > best.error ? risen + 1 : 0;
        if (error <= best.error) best.prior = prior, best.error = error;
    }
    return best;
}

}  // namespace

NetChoice chooseNet(const Matrix& inputs, const Matrix& outputs, const std::vector<int>& folds,
                    const NetSearch& search) {
    assert(inputs.rows == outputs.rows && folds.size() == inputs.rows && !search.neurons.empty());
    // 1. Merge the folds.
    const std::vector<int> merged = mergeFolds(folds, search.folds);
    const int count = folds.empty() ? 0 : 1 + *std::max_element(merged.begin(), merged.end());
    // With no second fold to validate on, take the strongest prior, which gives nearly the mean alone.
    if (count < 2) return {search.neurons.front(), search.most_prior, 0};
    // 2. Choose the prior with the first number of neurons, then try the other numbers with that prior.
    std::vector<NetFold> parts;
    for (int f = 0; f < count; ++f) parts.push_back(makeFold(inputs, outputs, merged, f, search.input_variance));
    std::vector<NetChoice> choices{choosePrior(parts, search)};
    for (std::size_t n = 1; n < search.neurons.size(); ++n) {
        std::vector<TanhNet> nets = startNets(parts, search.neurons[n], search.seed);
        choices.push_back({search.neurons[n], choices[0].prior, advanceAll(parts, choices[0].prior, nets)});
    }
    // 3. Take the smallest net whose error is nearly the least.
    double least = std::numeric_limits<double>::infinity();
    for (const NetChoice& c : choices) least = std::min(least, c.error);
    std::erase_if(choices, [&](const NetChoice& c) { return c.error > kTolerated * kTolerated * least; });
    return *std::min_element(choices.begin(), choices.end(),
                             [](const NetChoice& a, const NetChoice& b) { return a.neurons < b.neurons; });
}

TanhNet fitChosenNet(const Matrix& inputs, const Matrix& outputs, const NetChoice& choice, const NetSearch& search) {
    const double input_scale = scaleOf(inputs), output_scale = scaleOf(outputs);
    const Matrix x = scaled(inputs, input_scale), y = scaled(outputs, output_scale);
    const StartPlan plan{.neurons = choice.neurons, .seed = search.seed};
    NetFit best = fitFromManyStarts(x, y, choice.prior * double(x.rows), plan, kFinal);
    asEigen(best.net.hidden) *= input_scale;
    asEigen(best.net.output) /= output_scale;
    for (double& b : best.net.output_bias) b /= output_scale;
    return best.net;
}

}  // namespace penumbra
