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
#include "pack/compress_model.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "pack/symmetric_eigen.h"

namespace penumbra {

namespace {

// Multiplies rows [r, k] by a matrix [k, n] in double.
template <class T>
std::vector<float> multiply(std::span<const double> rows, const std::vector<T>& matrix, std::size_t k) {
    if (k == 0) return {};
    const std::size_t count = rows.size() / k, n = matrix.size() / k;
    std::vector<float> out(count * n);
    std::vector<double> sum(n);
    for (std::size_t r = 0; r < count; ++r) {
        std::fill(sum.begin(), sum.end(), 0.0);
        for (std::size_t i = 0; i < k; ++i)
            for (std::size_t j = 0; j < n; ++j) sum[j] += rows[r * k + i] * double(matrix[i * n + j]);
        std::copy(sum.begin(), sum.end(), out.begin() + std::ptrdiff_t(r * n));
    }
    return out;
}

// Returns the mean of the scores over the frames.
std::vector<double> meanScores(std::span<const float> scores, std::size_t components) {
    std::vector<double> mean(components);
    for (std::size_t i = 0; i < scores.size(); ++i) mean[i % components] += scores[i];
    for (double& m : mean) m /= std::max(1.0, double(scores.size() / components));
    return mean;
}

// Returns the sum over frames of (y - mean)(y - mean)^T.
std::vector<double> scatterOf(std::span<const float> scores, const std::vector<double>& mean) {
    const std::size_t k = mean.size();
    std::vector<double> scatter(k * k), y(k);
    for (std::size_t first = 0; first < scores.size(); first += k) {
        for (std::size_t i = 0; i < k; ++i) y[i] = scores[first + i] - mean[i];
        for (std::size_t i = 0; i < k; ++i)
            for (std::size_t j = 0; j <= i; ++j) scatter[i * k + j] += y[i] * y[j];
    }
    for (std::size_t i = 0; i < k; ++i)
        for (std::size_t j = 0; j < i; ++j) scatter[j * k + i] = scatter[i * k + j];
    return scatter;
}

// Returns the inner products of the components, of which only the lower triangle is filled in.
std::vector<double> gramOf(const std::vector<float>& basis, std::size_t components) {
    const std::size_t length = basis.size() / components;
    std::vector<double> gram(components * components);
    for (std::size_t i = 0; i < components; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = 0;
            for (std::size_t n = 0; n < length; ++n) sum += double(basis[i * length + n]) * basis[j * length + n];
            gram[i * components + j] = sum;
        }
    return gram;
}

// The turn of scores, y' = scores (y - mean), and of components, basis' = basis_rows basis. On the span of the
// components scores^T basis_rows = 1.
struct Turn {
    std::vector<double> scores, basis;  // [K', K]
    std::vector<double> energies;       // [K']
};

// Finds the turn. The Gram matrix of the components is U^T diag(s) U, so that sqrt(s) U y are the scores of the
// orthonormal components U basis / sqrt(s). The scatter of these scores, Q^T diag(energies) Q, gives the axes: scores
// = Q sqrt(s) U, basis = Q U / sqrt(s).
Turn principalTurn(const std::vector<double>& gram, const std::vector<double>& scatter, std::size_t components) {
    const SymmetricEigen span = symmetricEigen(gram, components);
    std::size_t rank = 0;
    while (rank < components && span.values[rank] > 1e-12 * span.values[0]) ++rank;
    std::vector<double> whole(rank * components), inverse(rank * components);
    for (std::size_t r = 0; r < rank; ++r)
        for (std::size_t k = 0; k < components; ++k) {
            const double length = std::sqrt(span.values[r]), u = span.vectors[r * components + k];
            whole[r * components + k] = length * u;
            inverse[r * components + k] = u / length;
        }
    std::vector<double> half(rank * components), turned(rank * rank);
    for (std::size_t r = 0; r < rank; ++r)
        for (std::size_t i = 0; i < components; ++i)
            for (std::size_t j = 0; j < components; ++j)
                half[r * components + j] += whole[r * components + i] * scatter[i * components + j];
    for (std::size_t r = 0; r < rank; ++r)
        for (std::size_t q = 0; q <= r; ++q) {
            double sum = 0;
            for (std::size_t j = 0; j < components; ++j) sum += half[r * components + j] * whole[q * components + j];
            turned[r * rank + q] = sum;
        }
    const SymmetricEigen axes = symmetricEigen(turned, rank);
    Turn turn{std::vector<double>(rank * components), std::vector<double>(rank * components), axes.values};
    for (std::size_t r = 0; r < rank; ++r)
        for (std::size_t q = 0; q < rank; ++q)
            for (std::size_t k = 0; k < components; ++k) {
                turn.scores[r * components + k] += axes.vectors[r * rank + q] * whole[q * components + k];
                turn.basis[r * components + k] += axes.vectors[r * rank + q] * inverse[q * components + k];
            }
    for (double& energy : turn.energies) energy = std::max(0.0, energy);
    return turn;
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
    const std::vector<double> mean = meanScores(scores, components);
    const Turn turn = principalTurn(gramOf(cluster.basis, components), scatterOf(scores, mean), components);
    if (turn.energies.empty()) {  // all components are zeros, as visibility never changes; one of them stays
        keepComponents(cluster, 1);
        return {0.0};
    }
    // 2. The mean score moves into the stored mean, so that the turned scores are centred.
    const std::size_t length = cluster.mean.size();
    for (std::size_t n = 0; n < length; ++n) {
        double sum = cluster.mean[n];
        for (std::size_t k = 0; k < components; ++k) sum += mean[k] * cluster.basis[k * length + n];
        cluster.mean[n] = float(sum);
    }
    // 3. Turn the components one way, and the regression's weights and bias the other way.
    std::vector<double> centred(components);
    for (std::size_t k = 0; k < components; ++k) centred[k] = cluster.bias[k] - mean[k];
    cluster.basis = multiply(turn.basis, cluster.basis, components);
    cluster.weights = multiply(turn.scores, cluster.weights, components);
    cluster.bias = multiply(turn.scores, centred, components);
    return turn.energies;
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
