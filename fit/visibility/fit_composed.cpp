// Fits one cluster of a composed model.
//
// Problem: predict what a vertex sees in poses that nobody baked. Parts of the body that hide the same piece of sky do
// not add up, so a sum over bones is wrong where two of them do.
//
// Naive: learn the visibility as a whole. It depends on all bones at once, and no bake shows all their combinations.
//
// Here: most of what hides the sky is far along the skeleton and rigid, so geometry gives it for any pose
// (sh/far/far_visibility.h). Only what nearby parts hide is learned, from the few joints between them, and is
// multiplied by the visibility of the far parts. The product is cut to a few bands and far parts bend a little after
// all; a second model, of all joints, learns what the product leaves.
#include "fit/visibility/fit_composed.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fit/numerics/pca.h"

namespace penumbra {

namespace {

// Sums over the vertices of one frame, for the three arrays of FrameErrors.
void addFrame(std::span<const float> ambient, std::span<const float> truth, std::span<const float> predicted,
              std::size_t f, FrameErrors& errors) {
    for (std::size_t c = 0; c < truth.size(); c += ambient.size()) {
        double e = 0;
        for (std::size_t i = 0; i < ambient.size(); ++i) {
            const double d = double(predicted[c + i]) - truth[c + i];
            errors.squared[f] += d * d;
            e += ambient[i] * d;
        }
        errors.ambient[f] += std::abs(e);
    }
}

FrameErrors noErrors(const std::vector<double>& variance) {
    FrameErrors errors(variance.size());
    errors.variance = variance;
    return errors;
}

std::vector<double> varianceOf(const MatrixF& coefficients, std::span<const std::size_t> train) {
    const std::vector<double> mean = meanOfRows(coefficients, train);
    std::vector<double> variance(coefficients.rows);
    for (std::size_t f = 0; f < coefficients.rows; ++f)
        for (std::size_t c = 0; c < coefficients.columns; ++c)
            variance[f] += (coefficients(f, c) - mean[c]) * (coefficients(f, c) - mean[c]);
    return variance;
}

void clampAll(std::span<const float> ambient, std::span<float> coefficients) {
    const float norm2 = std::inner_product(ambient.begin(), ambient.end(), ambient.begin(), 0.0f);
    for (std::size_t c = 0; c < coefficients.size(); c += ambient.size())
        clampAmbient(ambient, norm2, coefficients.subspan(c, ambient.size()));
}

// Fills in the energies of what is left.
void measureLeft(const ComposedProblem& problem, const MatrixF& whole, ComposedFit& fit) {
    const std::span<const std::size_t> train = problem.local.train;
    const std::vector<int>& folds = *problem.local.folds;
    const std::vector<double> variance = varianceOf(whole, train);
    for (const std::size_t f : train) fit.left += variance[f];
    for (int fold = 0; fold <= *std::max_element(folds.begin(), folds.end()); ++fold) {
        std::vector<std::size_t> others, own;
        for (std::size_t i = 0; i < train.size(); ++i) (folds[i] == fold ? own : others).push_back(train[i]);
        const std::vector<double> mean =
            others.empty() ? std::vector<double>(whole.columns) : meanOfRows(whole, others);
        for (const std::size_t f : own)
            for (std::size_t c = 0; c < whole.columns; ++c) {
                const double x = whole(f, c);
                fit.left_as_it_is += x * x;
                fit.left_about_others += (x - mean[c]) * (x - mean[c]);
            }
    }
}

}  // namespace

namespace {

// Multiplies the predicted and the true local numbers, [F, Vc n] each, by the far parts, and the predicted ones by the
// near parts as well.
void multiplyParts(const ComposedProblem& problem, const VertexSet& vertices, MatrixF& predicted, MatrixF& exact) {
    const std::size_t parts = problem.far->partCount();
    VertexSet without_near = vertices;
    std::fill(without_near.gains.begin(), without_near.gains.end(), std::uint8_t(0));
    std::vector<float> far(vertices.part.size() * kFarCoefficients);
    for (std::size_t f = 0; f < predicted.rows; ++f) {
        const SetPose pose = poseOfSet(vertices, *problem.local.poses, f, problem.posed.subspan(f * parts, parts));
        farFactors(*problem.far, vertices, pose, far);
        multiplyByFar(*problem.far, far, predicted.row(f));
        if (!vertices.gains.empty()) farFactors(*problem.far, without_near, pose, far);
        multiplyByFar(*problem.far, far, exact.row(f));
    }
}

}  // namespace

ComposedFit fitComposed(const ComposedProblem& problem, MatrixF& local, MatrixF& whole) {
    const std::vector<float>& ambient = problem.local.ambient_weights;
    const std::size_t frames = whole.rows;
    ComposedFit fit;
    // 1. Learn the local numbers, without the near parts. The fit turns them into truth - prediction.
    MatrixF exact = local;
    VertexSet vertices = *problem.vertices;
    if (problem.near) {
        fit.near_gains = takeOutNearParts(*problem.near, vertices.id, local);
        if (problem.near->hidden == HiddenVertices::kOpened)
            openHidden(hiddenByParts(*problem.near, vertices.id, whole, ambient), fit.near_gains, local);
        vertices.gains = fit.near_gains;
    }
    MatrixF product = local;
    fit.local = fitCluster(problem.local, local);
    for (std::size_t i = 0; i < product.values.size(); ++i) product.values[i] -= local.values[i];
    // 2. Multiply predictions and truth by the far parts. `whole` becomes what the product leaves.
    multiplyParts(problem, vertices, product, exact);
    const std::vector<double> variance = varianceOf(whole, problem.local.train);
    fit.errors = fit.without_residual = fit.split = noErrors(variance);
    MatrixF truth = whole;
    for (std::size_t f = 0; f < frames; ++f) {
        for (std::size_t c = 0; c < whole.columns; ++c) whole(f, c) -= product(f, c);
        clampAll(ambient, exact.row(f));
        addFrame(ambient, truth.row(f), exact.row(f), f, fit.split);
        clampAll(ambient, product.row(f));
        addFrame(ambient, truth.row(f), product.row(f), f, fit.without_residual);
    }
    // 3. Learn what is left.
    measureLeft(problem, whole, fit);
    fit.with_mean = noErrors(variance);
    const std::vector<double> mean = meanOfRows(whole, problem.local.train);
    std::vector<float> sum(whole.columns);
    for (std::size_t f = 0; f < frames; ++f) {
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] = truth(f, c) - whole(f, c) + float(mean[c]);
        clampAll(ambient, sum);
        addFrame(ambient, truth.row(f), sum, f, fit.with_mean);
    }
    fit.residual = fitCluster(problem.residual, whole);
    // 4. Measure the whole prediction. `whole` now holds what it leaves before the clamp.
    for (std::size_t f = 0; f < frames; ++f) {
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] = truth(f, c) - whole(f, c);
        clampAll(ambient, sum);
        addFrame(ambient, truth.row(f), sum, f, fit.errors);
    }
    return fit;
}

}  // namespace penumbra
