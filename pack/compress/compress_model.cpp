// Makes a model smaller by dropping the components that matter least.
//
// Problem: a component costs bytes at every vertex of its cluster. Which components can go, in which clusters, so
// that the predictions change least?
//
// Naive: drop the last components of the output PCA. These are ordered by the variance of the truth. A model predicts
// only a part of it, so a component that matters much in the truth may hardly move in predictions, and predicted
// scores are correlated, so that several components may move together where one would do.
//
// Here: first turn each cluster's components to the principal axes of its own predictions over the training frames.
// This changes no number. Leaving out component k then changes the sum of squared numbers by exactly its energy
// lambda_k, and energies add up over components and clusters. So a greedy choice is nearly the best: drop the
// component that loses the least energy for each byte saved, over all clusters, until the bytes or the error are as
// asked (docs/formulas.md, end of section 4).
#include "pack/compress/compress_model.h"

#include <algorithm>
#include <cassert>

#include "pack/compress/dense_solvers.h"

namespace penumbra {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
template <class T>
using Rows = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The rows [k, n] of a matrix as doubles, of which there may be none.
MatrixXd asRows(std::span<const float> values, std::size_t k) {
    return Eigen::Map<const Rows<float>>(values.data(), Index(k), Index(values.size() / k)).cast<double>();
}

std::vector<float> asFloats(const MatrixXd& rows) {
    std::vector<float> values(std::size_t(rows.size()));
    Eigen::Map<Rows<float>>(values.data(), rows.rows(), rows.cols()) = rows.cast<float>();
    return values;
}

// The turn of scores, y' = scores (y - mean), and of components, basis' = basis_rows basis. On the span of the
// components scores^T basis_rows = 1.
struct Turn {
    MatrixXd scores, basis;    // [K', K]
    Eigen::VectorXd energies;  // [K'], descending
};

// Finds the turn. The Gram matrix of the components is U^T diag(s) U, so that sqrt(s) U y are the scores of the
// orthonormal components U basis / sqrt(s). The scatter of these scores, Q^T diag(energies) Q, gives the axes: scores
// = Q sqrt(s) U, basis = Q U / sqrt(s).
Turn principalTurn(const MatrixXd& gram, const MatrixXd& scatter) {
    const SymmetricAxes span = symmetricAxes(gram);
    const Index rank = (span.values.array() > 1e-12 * span.values[0]).count();
    if (rank == 0) return {};
    const Eigen::VectorXd lengths = span.values.head(rank).cwiseSqrt();
    const MatrixXd u = span.axes.leftCols(rank).transpose(), whole = lengths.asDiagonal() * u;
    const SymmetricAxes axes = symmetricAxes(whole * scatter * whole.transpose());
    const MatrixXd q = axes.axes.transpose();
    return {q * whole, q * (lengths.cwiseInverse().asDiagonal() * u), axes.values.cwiseMax(0.0)};
}

// Drops components until `enough` says that the next one must stay.
template <class Enough>
ComponentChoice dropUntil(const ComponentCosts& costs, Enough enough) {
    struct Candidate {
        double energy, bytes;
        std::size_t cluster;
    };
    std::vector<Candidate> candidates;
    ComponentChoice choice;
    // Every component is a candidate, except for those of each cluster that must stay.
    for (std::size_t c = 0; c < costs.energies.size(); ++c) {
        const std::size_t least = costs.least.empty() ? 1 : costs.least[c];
        choice.kept.push_back(costs.energies[c].size());
        for (std::size_t k = costs.energies[c].size(); k-- > least;)
            candidates.push_back({costs.energies[c][k], costs.bytes[c], c});
    }
    // Within a cluster bytes are equal and energies descend, so that its last component always goes first.
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.energy * b.bytes < b.energy * a.bytes; });
    for (const Candidate& candidate : candidates) {
        if (enough(choice, candidate.energy)) break;
        --choice.kept[candidate.cluster];
        choice.dropped_energy += candidate.energy;
        choice.dropped_bytes += candidate.bytes;
    }
    return choice;
}

template <class AnyModel>
auto clustersOf(AnyModel& model) {
    std::vector<decltype(&model.clusters[0])> all;
    for (auto& cluster : model.clusters) all.push_back(&cluster);
    if (model.composition)
        for (auto& cluster : model.composition->residual) all.push_back(&cluster);
    return all;
}

}  // namespace

std::vector<const ClusterModel*> allClusters(const Model& model) { return clustersOf(model); }
std::vector<ClusterModel*> allClusters(Model& model) { return clustersOf(model); }

std::vector<double> turnToPrincipalAxes(ClusterModel& cluster, std::span<const float> scores) {
    const std::size_t components = cluster.components();
    if (components == 0 || cluster.basis.empty()) return std::vector<double>(components);
    assert(scores.size() % components == 0);
    // 1. Find the axes of the predicted scores.
    const MatrixXd basis = asRows(cluster.basis, components);
    MatrixXd y = Eigen::Map<const Eigen::MatrixXf>(scores.data(), Index(components), Index(scores.size() / components))
                     .cast<double>();  // [K, frames]
    const Eigen::VectorXd mean = y.rowwise().sum() / std::max(1.0, double(y.cols()));
    y.colwise() -= mean;
    const Turn turn = principalTurn(basis * basis.transpose(), y * y.transpose());
    if (turn.energies.size() == 0) {  // all components are zeros, as visibility never changes; one of them stays
        keepComponents(cluster, 1);
        return {0.0};
    }
    // 2. The mean score moves into the stored mean, so that the turned scores are centered.
    cluster.mean = asFloats(asRows(cluster.mean, 1) + mean.transpose() * basis);
    // 3. Turn the components one way, and the regression's weights and bias the other way.
    const MatrixXd bias = asRows(cluster.bias, components) - mean;
    cluster.basis = asFloats(turn.basis * basis);
    cluster.weights = asFloats(turn.scores * asRows(cluster.weights, components));
    cluster.bias = asFloats(turn.scores * bias);
    return {turn.energies.begin(), turn.energies.end()};
}

void keepComponents(ClusterModel& cluster, std::size_t count) {
    assert(count <= cluster.components());
    cluster.weights.resize(count * cluster.units());
    cluster.basis.resize(count * cluster.mean.size());
    cluster.bias.resize(count);
    if (count > 0) return;
    for (std::vector<float>* unused : {&cluster.hidden, &cluster.group_weight, &cluster.group_min, &cluster.group_max})
        unused->clear();
    cluster.unit_group.clear();
    cluster.groups.clear();
}

ComponentChoice dropForBytes(const ComponentCosts& costs, double bytes) {
    return dropUntil(costs, [&](const ComponentChoice& so_far, double) { return so_far.dropped_bytes >= bytes; });
}

ComponentChoice dropForEnergy(const ComponentCosts& costs, double energy) {
    return dropUntil(costs,
                     [&](const ComponentChoice& so_far, double next) { return so_far.dropped_energy + next > energy; });
}

}  // namespace penumbra
