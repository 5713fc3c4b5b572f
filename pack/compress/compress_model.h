#pragma once
// Removes components where they matter least. Output PCA orders a cluster's components by the variance of the truth,
// but a model predicts only a part of that, and its scores are correlated. The principal axes of the predicted scores
// are fewer, and dropping the last of them costs least (docs/formulas.md, end of section 4).
#include <cstddef>
#include <span>
#include <vector>

#include "formats/stage/model_file.h"

namespace penumbra {

// Lists the clusters of a model, then those of its residual.
std::vector<const ClusterModel*> allClusters(const Model& model);
std::vector<ClusterModel*> allClusters(Model& model);

// Turns the components of `cluster` to the principal axes of the numbers that it predicts. `scores` [F, K] are its
// scores over the training frames. No number changes, up to rounding. With y = W^T y' + mean score and orthonormal
// new components,
//   mean += sum_k (mean score)_k basis_k,  weights' = R weights,  bias' = R (bias - mean score).
// Directions in which the old components repeat one another (to 1e-12) disappear. Returns the energies [K'] in
// descending order: sum over frames of y'_k^2, in squared numbers. That is what dropping the component costs.
std::vector<double> turnToPrincipalAxes(ClusterModel& cluster, std::span<const float> scores);

// Keeps the first `count`. A cluster without components loses its units and groups too.
void keepComponents(ClusterModel& cluster, std::size_t count);

// The components of all clusters, as a choice among them sees them.
struct ComponentCosts {
    std::vector<std::vector<double>> energies;  // [cluster, K] descending
    std::vector<double> bytes;                  // [cluster], bytes of one component
    // [cluster], how many must stay, for clusters that had as many; empty: one of each
    std::vector<std::size_t> least = {};
};

struct ComponentChoice {
    std::vector<std::size_t> kept;  // [cluster]
    double dropped_energy = 0, dropped_bytes = 0;
};

// Drop components in the order of energy lost for a byte saved, least first. dropForBytes() stops when `bytes` are
// saved or nothing is left to drop, dropForEnergy() before the loss would exceed `energy` in all.
ComponentChoice dropForBytes(const ComponentCosts& costs, double bytes);
ComponentChoice dropForEnergy(const ComponentCosts& costs, double energy);

}  // namespace penumbra
