#include "fit/papers/compare/eigenvalue_decay.h"

#include <algorithm>

#include "fit/numerics/leading_components.h"
#include "fit/numerics/pca.h"
#include "fit/visibility/fit_batches.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kStackedComponents = 200;  // of the rows that Nowrouzezahrai 2007 stacks

// Returns each value's share of their sum.
std::vector<double> sharesOfSum(const std::vector<double>& values) {
    double total = 0;
    for (double value : values) total += value;
    return sharesOf(values, total);
}

// Returns the mean of each share over the clusters in which something varies. A cluster with fewer components counts as
// 0 beyond them.
std::vector<double> meanShares(const std::vector<std::vector<double>>& of_cluster) {
    const auto varying = std::count_if(of_cluster.begin(), of_cluster.end(), [](const auto& s) { return !s.empty(); });
    std::vector<double> mean;
    for (const std::vector<double>& shares : of_cluster) {
        mean.resize(std::max(mean.size(), shares.size()));
        for (std::size_t i = 0; i < shares.size(); ++i) mean[i] += shares[i] / double(varying);
    }
    return mean;
}

// Returns the poses as a matrix. For a deforming mesh they are the angles that its own PCA kept, and the inputs.
Matrix poseMatrix(const PoseTable& poses) {
    Matrix pose(poses.frameCount(), poses.pose_size);
    std::copy(poses.pose.begin(), poses.pose.end(), pose.values.begin());
    return pose;
}

// Returns the raw features of a cluster, weighted as the fit weighs them before its input PCA.
Matrix boneFeatures(const CompareInput& input, const CompareCharacter& character, const FeatureRecipe& recipe,
                    std::size_t cluster) {
    const int joint = character.clusters.joint[cluster];
    Matrix raw = rawFeatures(recipe, joint, input.poses);
    const Vec3 center = centerOf(input.reader.header().mesh, character.clusters.vertices[cluster]);
    const std::vector<double> weights = featureWeights(recipe, {joint, center}, raw, character.train);
    for (std::size_t f = 0; f < raw.rows; ++f)
        for (std::size_t c = 0; c < raw.columns; ++c) raw(f, c) *= weights[c];
    return raw;
}

// Stacks numbers [F, vertices n] of some clusters as Nowrouzezahrai 2007 does: row i * train + f has number i of all
// vertices in training frame f.
MatrixF stacked(const std::vector<MatrixF>& coefficients, const std::vector<std::size_t>& train, std::size_t n) {
    std::size_t vertices = 0, at = 0;
    for (const MatrixF& cluster : coefficients) vertices += cluster.columns / n;
    MatrixF rows(n * train.size(), vertices);
    for (const MatrixF& cluster : coefficients) {
        for (std::size_t f = 0; f < train.size(); ++f)
            for (std::size_t c = 0; c < cluster.columns; ++c)
                rows(c % n * train.size() + f, at + c / n) = cluster(train[f], c);
        at += cluster.columns / n;
    }
    return rows;
}

}  // namespace

std::vector<double> sharesOf(std::vector<double> values, double total) {
    if (total <= 0) return {};
    for (double& value : values) value /= total;
    return values;
}

bool EigenvalueDecay::reaches(double share) const {
    double sum = 0;
    for (const double part : shares) sum += part;
    return sum >= share - 1e-9;
}

std::size_t EigenvalueDecay::componentsFor(double share) const {
    std::size_t count = 0;
    for (double sum = 0; count < shares.size() && sum < share - 1e-9; ++count) sum += shares[count];
    return std::max<std::size_t>(count, 1);
}

std::vector<EigenvalueDecay> inputDecays(const CompareInput& input, const CompareCharacter& character) {
    std::vector<EigenvalueDecay> decays;
    if (input.poses.pose_size > 0) {
        const Pca pca = principalComponents(centeredRows(poseMatrix(input.poses), character.train));
        decays.push_back({input.poses.deforming ? "dihedral angles" : "joint angles", sharesOfSum(pca.energies)});
    }
    if (input.poses.joints < 2) return decays;
    const FeatureRecipe recipe = recipeFor(input, FeatureKind::kRelativeBones);
    std::vector<std::vector<double>> of_cluster;
    for (std::size_t c = 0; c < character.clusters.vertices.size(); ++c) {
        throwIfInterrupted();
        const Matrix features = boneFeatures(input, character, recipe, c);
        of_cluster.push_back(sharesOfSum(principalComponents(centeredRows(features, character.train)).energies));
    }
    decays.push_back({"relative bones, mean over clusters", meanShares(of_cluster)});
    return decays;
}

std::vector<EigenvalueDecay> outputDecays(const CompareInput& input, const CompareCharacter& character,
                                          const CompareOptions& options, const std::function<void(double)>& progress) {
    const VertexClusters& clusters = character.clusters;
    const std::size_t frames = input.poses.frameCount(), train = character.train.size();
    ClusterCoefficientsRequest request = requestFor(character, options.referenceConvention(), options.threads);
    const std::size_t n = std::size_t(request.convention.size());
    std::vector<Matrix> grams(clusters.vertices.size());
    const auto batches = makeBatches(clusters.vertices, frames * n * sizeof(float));
    const auto readBatch = [&](std::size_t begin, std::size_t end) {
        request.vertices_of_cluster = std::span(clusters.vertices).subspan(begin, end - begin);
        return readClusterCoefficients(input.reader, input.poses, request);
    };
    // 1. Compute the Gram matrix of every cluster's numbers over training frames. It has the same eigenvalues as the
    //    covariance.
    for (const auto& [begin, end] : batches) {
        const std::vector<MatrixF> coefficients = readBatch(begin, end);
        parallelFor(coefficients.size(), options.threads, [&, begin = begin](std::size_t i) {
            throwIfInterrupted();
            grams[begin + i] = Matrix(train, train);
            addGram(centeredRows(coefficients[i], character.train), grams[begin + i]);
        });
        if (progress) progress(0.5 * double(end) / double(grams.size()));
    }
    // 2. The Gram matrix of all vertices is the sum of those of the clusters.
    Matrix sum(train, train);
    std::vector<std::vector<double>> of_cluster(grams.size());
    for (const Matrix& gram : grams)
        for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += gram.values[i];
    parallelFor(grams.size(), options.threads,
                [&](std::size_t c) { of_cluster[c] = sharesOfSum(eigenvalues(grams[c])); });
    // 3. The rows of Nowrouzezahrai 2007 have no such sum: their components are found in several passes.
    const ColumnBlocks rows{
        n * train, input.reader.header().mesh.vertexCount(), batches.size(), [&](std::size_t batch) {
            return stacked(readBatch(batches[batch].first, batches[batch].second), character.train, n);
        }};
    const LeadingSpace space = leadingSpace(rows, kStackedComponents, options.threads);
    if (progress) progress(1);
    return {{"all vertices together, a row a pose", sharesOfSum(eigenvalues(sum))},
            {"all vertices together, a row a pose and number", sharesOf(space.energies, space.total)},
            {"a cluster, mean over clusters", meanShares(of_cluster)}};
}

}  // namespace penumbra
