#include "fit/compare/eigenvalue_decay.h"

#include <algorithm>

#include "fit/models/features.h"
#include "fit/numerics/leading_components.h"
#include "fit/numerics/pca.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kStackedComponents = 200;  // of the rows that Nowrouzezahrai 2007 stacks

template <class T>
BasicMatrix<T> centredRows(const BasicMatrix<T>& all, std::span<const std::size_t> rows) {
    const std::vector<double> mean = meanOfRows(all, rows);
    BasicMatrix<T> out(rows.size(), all.columns);
    for (std::size_t r = 0; r < rows.size(); ++r)
        for (std::size_t c = 0; c < all.columns; ++c) out(r, c) = T(double(all(rows[r], c)) - mean[c]);
    return out;
}

// Returns each value's share of their sum. The result is empty when nothing varies.
std::vector<double> sharesOf(std::vector<double> values) {
    double total = 0;
    for (double value : values) total += value;
    if (total <= 0) return {};
    for (double& value : values) value /= total;
    return values;
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
    Matrix raw(input.poses.frameCount(), recipe.count());
    for (std::size_t f = 0; f < raw.rows; ++f)
        rawFeatures(recipe, joint, input.poses.bonesOf(f), input.poses.rotationsOf(f), input.poses.poseOf(f),
                    raw.row(f));
    const Vec3 center = centerOfVertices(input.reader.header().mesh, character.clusters.vertices[cluster]);
    const std::vector<double> weights = featureWeights(recipe, {joint, center}, raw, character.train);
    for (std::size_t f = 0; f < raw.rows; ++f)
        for (std::size_t c = 0; c < raw.columns; ++c) raw(f, c) *= weights[c];
    return raw;
}

// Stacks numbers [F, vertices n] of some clusters as Nowrouzezahrai 2007 does: row i * train + f has number i of all
// vertices in training frame f.
MatrixF stacked(const std::vector<MatrixF>& numbers, const std::vector<std::size_t>& train, std::size_t n) {
    std::size_t vertices = 0, at = 0;
    for (const MatrixF& cluster : numbers) vertices += cluster.columns / n;
    MatrixF rows(n * train.size(), vertices);
    for (const MatrixF& cluster : numbers) {
        for (std::size_t f = 0; f < train.size(); ++f)
            for (std::size_t c = 0; c < cluster.columns; ++c)
                rows(c % n * train.size() + f, at + c / n) = cluster(train[f], c);
        at += cluster.columns / n;
    }
    return rows;
}

}  // namespace

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
    const VisibilityHeader& header = input.reader.header();
    std::vector<EigenvalueDecay> decays;
    if (input.poses.pose_size > 0) {
        const Pca pca = principalComponents(centredRows(poseMatrix(input.poses), character.train));
        decays.push_back({input.poses.deforming ? "dihedral angles" : "joint angles", sharesOf(pca.energies)});
    }
    if (input.poses.joints < 2) return decays;
    FeatureRecipe recipe{FeatureKind::kRelativeBones,
                         boxDiagonal(header.mesh.rest_positions),
                         input.poses.joint_centers,
                         {},
                         input.poses.pose_size};
    recipe.input_joints = input.poses.input_joints;
    std::vector<std::vector<double>> of_cluster;
    for (std::size_t c = 0; c < character.clusters.vertices.size(); ++c) {
        throwIfInterrupted();
        const Matrix features = boneFeatures(input, character, recipe, c);
        of_cluster.push_back(sharesOf(principalComponents(centredRows(features, character.train)).energies));
    }
    decays.push_back({"relative bones, mean over clusters", meanShares(of_cluster)});
    return decays;
}

std::vector<EigenvalueDecay> outputDecays(const CompareInput& input, const CompareCharacter& character,
                                          const CompareOptions& options, const std::function<void(double)>& progress) {
    const VertexClusters& clusters = character.clusters;
    const std::size_t frames = input.poses.frameCount(), train = character.train.size();
    ClusterNumbersRequest request;
    request.convention = options.referenceConvention();
    request.frames = {&character.rest_tangents, &clusters.cluster_of_vertex, clusters.joint};
    request.threads = options.threads;
    const std::size_t n = std::size_t(request.convention.size());
    std::vector<Matrix> grams(clusters.vertices.size());
    const std::vector<std::size_t> starts = batchStarts(clusters, frames * n * sizeof(float));
    const auto readBatch = [&](std::size_t batch) {
        request.vertices_of_cluster =
            std::span(clusters.vertices).subspan(starts[batch], starts[batch + 1] - starts[batch]);
        return readClusterNumbers(input.reader, input.poses, request);
    };
    // 1. Compute the Gram matrix of every cluster's numbers over training frames. It has the same eigenvalues as the
    //    covariance.
    for (std::size_t batch = 0; batch + 1 < starts.size(); ++batch) {
        const std::vector<MatrixF> numbers = readBatch(batch);
        parallelFor(numbers.size(), options.threads, [&](std::size_t i) {
            throwIfInterrupted();
            grams[starts[batch] + i] = Matrix(train, train);
            addGram(centredRows(numbers[i], character.train), grams[starts[batch] + i]);
        });
        if (progress) progress(0.5 * double(starts[batch + 1]) / double(grams.size()));
    }
    // 2. The Gram matrix of all vertices is the sum of those of the clusters.
    Matrix sum(train, train);
    std::vector<std::vector<double>> of_cluster(grams.size());
    for (const Matrix& gram : grams)
        for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += gram.values[i];
    parallelFor(grams.size(), options.threads, [&](std::size_t c) { of_cluster[c] = sharesOf(eigenvalues(grams[c])); });
    // 3. The rows of Nowrouzezahrai 2007 have no such sum: their components are found in several passes.
    const ColumnBlocks rows{n * train, input.reader.header().mesh.vertexCount(), starts.size() - 1,
                            [&](std::size_t batch) { return stacked(readBatch(batch), character.train, n); }};
    const LeadingSpace space = leadingSpace(rows, kStackedComponents, options.threads);
    if (progress) progress(1);
    std::vector<double> shares;
    for (const double energy : space.energies)
        if (space.total > 0) shares.push_back(energy / space.total);
    return {{"all vertices together, a row a pose", sharesOf(eigenvalues(sum))},
            {"all vertices together, a row a pose and number", shares},
            {"a cluster, mean over clusters", meanShares(of_cluster)}};
}

}  // namespace penumbra
