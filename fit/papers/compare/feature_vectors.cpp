// Problem: the paper says that feature vectors of higher order overfit, and that a model which only has to reproduce
// its training frames should have no prior. Both are questions about one family: ridge regressions on polynomials of
// the reduced inputs.
//
// Naive: a kind of model for each, through fit, file and run time. Nobody would use them.
//
// Here: the same PCA of features and of numbers as in fit/visibility/fit_cluster.cpp, one SVD of the polynomials for
// both priors, and errors from the scores alone: the basis is orthonormal, so |t - B^T p|^2 = |t|^2 - 2 (B t).p +
// |p|^2.
#include "fit/papers/compare/feature_vectors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fit/models/trainers.h"
#include "fit/numerics/cross_validation.h"
#include "fit/numerics/eigen_map.h"
#include "fit/numerics/ridge_path.h"
#include "fit/papers/compare/compare_grid.h"
#include "fit/visibility/fit_batches.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/vec3.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxCubicInputs = 21;  // 1,771 products of three
constexpr std::size_t kPriors = 2;

// What all fits of one kind of features share.
struct VectorJob {
    const CompareInput& input;
    const CompareCharacter& character;
    FeatureRecipe recipe;
    std::vector<int> folds;
    double input_variance = 0.9, output_variance = 0.95;
    std::vector<float> ambient = {};  // weights of E
    const JointSweep* sweep = nullptr;
};

// The errors and the sizes of one cluster's fits; fit 2 (degree - 1) has the prior, the next one none.
struct ClusterVectors {
    std::vector<double> variance;  // [F] |truth - training mean|^2
    std::array<std::vector<double>, kMaxDegree * kPriors> squared;
    std::array<double, kMaxDegree> units{};
    std::array<std::vector<double>, kMaxDegree * kPriors> turn_ambient;
    std::size_t inputs = 0, components = 0, raw_features = 0, coefficients = 0;
};

// Chooses alpha as the fits do.
double bestPrior(const VectorJob& job, const InputPca& inputs, const Pca& outputs, int degree) {
    const std::vector<double> alphas = ridgePriors(degree, inputs, job.character.train.size());
    Expansion expand;
    if (degree > 1)
        expand = [degree](const Matrix& x) {
            throwIfInterrupted();  // once a fold, which takes most of a second for cubic vectors
            return polynomialInputs(x, degree);
        };
    return alphas[strongestOfBest(
        blockedErrors(inputs.weighted, outputs.scores, job.folds, job.input_variance, alphas, expand))];
}

// Reduces raw features [n, N] to inputs [n, I], times `scale`.
Matrix reducedInputs(const ClusterModel& ranges, double scale, const Matrix& raw) {
    Matrix x(raw.rows, ranges.input_min.size());
    for (std::size_t r = 0; r < raw.rows; ++r) {
        const std::vector<float> row = pcaInputs(ranges, raw.row(r));
        for (std::size_t i = 0; i < row.size(); ++i) x(r, i) = scale * double(row[i]);
    }
    return x;
}

Matrix rawOfSweep(const VectorJob& job, int joint) {
    Matrix raw(job.sweep->angles.size(), job.recipe.count());
    for (std::size_t a = 0; a < raw.rows; ++a) {
        const TurnedPose turned = poseAt(job.input, job.sweep->turn, job.sweep->angles[a]);
        rawFeatures(job.recipe, joint, turned.bones, rotationsOf(turned.bones), turned.pose, raw.row(a));
    }
    return raw;
}

// A trained regression: scores = (units - mean) weights.
Matrix predictScores(const RidgeSvd& svd, const Eigen::MatrixXd& weights, const Matrix& units) {
    Matrix scores(units.rows, std::size_t(weights.cols()));
    const Eigen::Map<const Eigen::RowVectorXd> mean(svd.mean.data(), Eigen::Index(svd.mean.size()));
    asEigen(scores) = (asEigen(units).rowwise() - mean) * weights;
    return scores;
}

// Returns E of vertex number `at` of the cluster for rows of scores, as the run time clamps it.
std::vector<double> ambientOf(const VectorJob& job, const std::vector<double>& mean, const MatrixF& basis,
                              std::size_t at, const Matrix& scores) {
    std::vector<double> out;
    const std::size_t n = job.ambient.size();
    for (std::size_t r = 0; r < scores.rows; ++r) {
        double e = 0;
        for (std::size_t i = 0; i < n; ++i) {
            double number = mean[at * n + i];
            for (std::size_t k = 0; k < scores.columns; ++k) number += scores(r, k) * double(basis(k, at * n + i));
            e += double(job.ambient[i]) * number;
        }
        out.push_back(std::clamp(e, 0.0, 1.0));
    }
    return out;
}

std::vector<double> squaredErrors(const std::vector<double>& variance, const Matrix& truth, const Matrix& predicted) {
    std::vector<double> squared;
    for (std::size_t f = 0; f < truth.rows; ++f) {
        double sum = variance[f];
        for (std::size_t k = 0; k < truth.columns; ++k) sum += predicted(f, k) * (predicted(f, k) - 2 * truth(f, k));
        squared.push_back(std::max(sum, 0.0));
    }
    return squared;
}

// Fits all degrees to the numbers [F, Vc n] of a cluster.
ClusterVectors fitCluster(const VectorJob& job, std::size_t cluster, const MatrixF& coefficients) {
    const std::vector<std::size_t>& train = job.character.train;
    const std::vector<std::uint32_t>& vertices = job.character.clusters.vertices[cluster];
    const int joint = job.character.clusters.joint[cluster];
    ClusterVectors out;
    // 1. Center the numbers and reduce them. The scores of all frames tell all errors.
    const std::vector<double> mean = meanOfRows(coefficients, train);
    MatrixF centered = coefficients;
    for (std::size_t f = 0; f < centered.rows; ++f) {
        double sum = 0;
        for (std::size_t c = 0; c < centered.columns; ++c) {
            centered(f, c) = float(double(centered(f, c)) - mean[c]);
            sum += double(centered(f, c)) * double(centered(f, c));
        }
        out.variance.push_back(sum);
    }
    const MatrixF kept = selectRows(centered, train);
    const Pca outputs = principalComponents(kept);
    out.components = componentsFor(outputs, job.output_variance);
    const MatrixF basis = basisOf(outputs, kept, out.components);
    Matrix truth(centered.rows, out.components);
    asEigen(truth) = (asEigen(centered) * asEigen(basis).transpose()).cast<double>();
    // 2. Reduce the features.
    const Matrix raw = rawFeatures(job.recipe, joint, job.input.poses);
    const ClusterPlace place{joint, centerOf(job.input.reader.header().mesh, vertices)};
    const std::vector<double> group_weights = groupWeights(job.recipe, place, raw, train);
    const RegressionProblem problem{
        job.recipe, place, raw, train, job.folds, group_weights, outputs, out.components, job.input_variance};
    const Matrix targets = keptScores(problem);
    const InputPca inputs = makeInputPca(problem);
    ClusterModel ranges;
    setInputs(inputs, componentsFor(inputs.pca, job.input_variance), ranges);
    out.inputs = ranges.input_min.size();
    out.raw_features = raw.columns;
    out.coefficients = coefficients.columns;
    const auto here = job.sweep ? std::find(vertices.begin(), vertices.end(), job.sweep->vertex) : vertices.end();
    // 3. Fit each degree twice.
    for (int degree = 1; degree <= kMaxDegree; ++degree) {
        throwIfInterrupted();
        const double scale = degree == 1 ? 1 : expansionScale(inputs.pca, train.size());
        const Matrix units = polynomialInputs(reducedInputs(ranges, scale, raw), degree);
        out.units[std::size_t(degree) - 1] = double(units.columns);
        const RidgeSvd svd = makeRidgeSvd(selectRows(units, train), std::min(train.size(), units.columns));
        for (std::size_t p = 0; p < kPriors; ++p) {
            const std::size_t at = kPriors * (std::size_t(degree) - 1) + p;
            const double alpha = p == 0 ? bestPrior(job, inputs, outputs, degree) : 0;
            const Eigen::MatrixXd weights = asEigen(svd.v) * (asEigen(weightsOperator(svd, alpha)) * asEigen(targets));
            out.squared[at] = squaredErrors(out.variance, truth, predictScores(svd, weights, units));
            if (here == vertices.end()) continue;
            const Matrix turned = polynomialInputs(reducedInputs(ranges, scale, rawOfSweep(job, joint)), degree);
            out.turn_ambient[at] =
                ambientOf(job, mean, basis, std::size_t(here - vertices.begin()), predictScores(svd, weights, turned));
        }
    }
    return out;
}

// Sums over the clusters, in their order.
VectorFit combined(const VectorJob& job, const std::vector<ClusterVectors>& clusters, int degree, std::size_t prior) {
    const std::size_t at = kPriors * (std::size_t(degree) - 1) + prior, frames = job.input.poses.frameCount();
    VectorFit fit;
    fit.features = job.recipe.kind;
    fit.degree = degree;
    fit.prior = prior == 0;
    fit.clusters = clusters.size();
    FrameErrors errors(frames);
    errors.ambient.assign(frames, std::numeric_limits<double>::quiet_NaN());
    double coefficients = 0;
    for (const ClusterVectors& cluster : clusters) {
        for (std::size_t f = 0; f < frames; ++f)
            errors.squared[f] += cluster.squared[at][f], errors.variance[f] += cluster.variance[f];
        const double count = double(clusters.size()), units = cluster.units[std::size_t(degree) - 1];
        fit.inputs += double(cluster.inputs) / count;
        fit.components += double(cluster.components) / count;
        fit.units += units / count;
        coefficients +=
            double((1 + cluster.components) * cluster.coefficients + (1 + cluster.inputs) * cluster.raw_features) +
            (1 + units) * double(cluster.components);
        if (!cluster.turn_ambient[at].empty()) fit.turn_ambient = cluster.turn_ambient[at];
    }
    const std::size_t vertices = job.input.reader.header().mesh.vertexCount();
    fit.train = figuresOf(errors, job.character.train, vertices);
    fit.held_out = figuresOf(errors, job.character.held_out, vertices);
    fit.bytes_per_vertex = 4 * coefficients / double(vertices);
    return fit;
}

// Fits all clusters to numbers in the reference's convention, some clusters at a time.
std::vector<ClusterVectors> fitClusters(const VectorJob& job, const CompareOptions& options,
                                        const std::function<void(double)>& progress) {
    const VertexClusters& clusters = job.character.clusters;
    const std::size_t bytes =
        job.input.poses.frameCount() * std::size_t(options.referenceConvention().size()) * sizeof(float);
    ClusterCoefficientsRequest request = requestFor(job.character, options.referenceConvention(), options.threads);
    std::vector<ClusterVectors> fits(clusters.vertices.size());
    for (const auto& [begin, end] : makeBatches(clusters.vertices, bytes)) {
        request.vertices_of_cluster = std::span(clusters.vertices).subspan(begin, end - begin);
        const std::vector<MatrixF> coefficients = readClusterCoefficients(job.input.reader, job.input.poses, request);
        parallelFor(coefficients.size(), options.threads, [&, begin = begin](std::size_t i) {
            throwIfInterrupted();
            fits[begin + i] = fitCluster(job, begin + i, coefficients[i]);
        });
        progress(double(end) / double(fits.size()));
    }
    return fits;
}

}  // namespace

const char* nameOfDegree(int degree) { return degree == 1 ? "linear" : degree == 2 ? "quadratic" : "cubic"; }

Matrix polynomialInputs(const Matrix& inputs, int degree) {
    if (degree == 1) return inputs;
    const Matrix lower = quadraticInputs(inputs);
    if (degree == 2) return lower;
    const std::size_t m = std::min(inputs.columns, kMaxCubicInputs);
    Matrix out(inputs.rows, lower.columns + m * (m + 1) * (m + 2) / 6);
    for (std::size_t r = 0; r < inputs.rows; ++r) {
        std::copy_n(lower.row(r).data(), lower.columns, out.row(r).data());
        std::size_t at = lower.columns;
        for (std::size_t i = 0; i < m; ++i)
            for (std::size_t j = i; j < m; ++j)
                for (std::size_t k = j; k < m; ++k) out(r, at++) = inputs(r, i) * inputs(r, j) * inputs(r, k);
    }
    return out;
}

std::vector<VectorFit> fitFeatureVectors(const CompareInput& input, const CompareCharacter& character,
                                         const CompareOptions& options, const JointSweep* sweep,
                                         const std::function<void(double)>& progress) {
    std::vector<VectorFit> fits;
    for (std::size_t i = 0; i < options.features.size(); ++i) {
        const FeatureKind kind = options.features[i];
        const FitOptions reference = referenceFit(options, ModelKind::kLinear, kind);
        VectorJob job{input, character, recipeFor(input, kind),
                      makeFolds(input.reader.header().frames, character.train)};
        job.input_variance = kind == FeatureKind::kDihedrals ? 1 : inputVariance(reference);
        job.output_variance = reference.output_variance;
        job.ambient = reference.form->ambient_weights(reference.convention);
        job.sweep = sweep;
        const std::vector<ClusterVectors> clusters = fitClusters(
            job, options, [&](double share) { progress((double(i) + share) / double(options.features.size())); });
        for (int degree = 1; degree <= kMaxDegree; ++degree)
            for (std::size_t prior = 0; prior < kPriors; ++prior)
                fits.push_back(combined(job, clusters, degree, prior));
    }
    return fits;
}

}  // namespace penumbra
