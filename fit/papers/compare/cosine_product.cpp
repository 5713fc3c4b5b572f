#include "fit/papers/compare/cosine_product.h"

#include <cmath>
#include <limits>

#include "fit/models/regressor.h"
#include "fit/papers/compare/paper_forms.h"
#include "fit/visibility/predict.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/write_file.h"
#include "sh/cosine_product.h"

namespace penumbra {

namespace {

// Returns mean plus scores times basis, [Vc n].
std::vector<double> predictedCoefficients(const Model& model, const FeatureRecipe& recipe, const ClusterModel& cluster,
                                          const PoseTable& poses, std::size_t frame) {
    std::vector<double> raw(recipe.count());
    rawFeatures(recipe, cluster.joint, poses.bonesOf(frame), poses.rotationsOf(frame), poses.poseOf(frame), raw);
    const std::vector<float> scores = scoreCluster(model.kind, recipe, cluster, raw).scores;
    std::vector<double> coefficients(cluster.mean.begin(), cluster.mean.end());
    for (std::size_t k = 0; k < scores.size(); ++k)
        for (std::size_t i = 0; i < coefficients.size(); ++i)
            coefficients[i] += double(scores[k]) * double(cluster.basis[k * coefficients.size() + i]);
    return coefficients;
}

// Returns |C v - truth|^2 summed over vertices.
double squaredError(const std::vector<double>& product, std::span<const double> coefficients,
                    std::span<const float> truth, std::size_t n) {
    double sum = 0;
    for (std::size_t v = 0; v < coefficients.size(); v += n)
        for (std::size_t i = 0; i < n; ++i) {
            double value = -double(truth[v + i]);
            for (std::size_t k = 0; k < n; ++k) value += product[i * n + k] * coefficients[v + k];
            sum += value * value;
        }
    return sum;
}

}  // namespace

double cosineProductError(const CompareInput& input, const Model& model, int threads) {
    const FeatureRecipe recipe = recipeOf(model);
    const std::size_t n = std::size_t(model.convention.size());
    const std::vector<double> product = cosineMatrix(model.convention.order, model.convention.order);
    const Split split = splitFrames(model.frames, model.holdout_clips);
    const std::vector<int> joints = jointsOfClusters(model);
    ClusterCoefficientsRequest request;
    request.convention = model.convention;
    request.form = &kCosineForm;
    request.frames = {&model.rest_tangents, &model.cluster_of_vertex, joints};
    request.threads = threads;
    double squared = 0, variance = 0;
    for (const ClusterModel& cluster : model.clusters) {
        throwIfInterrupted();
        request.vertices_of_cluster = std::span(&cluster.vertices, 1);
        const MatrixF truth = std::move(readClusterCoefficients(input.reader, input.poses, request).front());
        const std::vector<double> mean = meanOfRows(truth, split.train);
        for (const std::size_t f : split.held_out) {
            squared +=
                squaredError(product, predictedCoefficients(model, recipe, cluster, input.poses, f), truth.row(f), n);
            for (std::size_t i = 0; i < mean.size(); ++i)
                variance += (double(truth(f, i)) - mean[i]) * (double(truth(f, i)) - mean[i]);
        }
    }
    return variance > 0 ? std::sqrt(squared / variance) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace penumbra
