#pragma once
// Fewer components where they matter least. Output PCA orders a cluster's components by the variance of the truth, but
// a model predicts only a part of it, and its scores are correlated: the principal axes of the predicted scores are
// fewer, and dropping the last of them costs least.
#include <cstddef>
#include <span>
#include <vector>

#include "formats/stage/model_file.h"

namespace penumbra {

// Turns the components of `cluster` to the principal axes of the numbers that it predicts. `scores` [F, K] are its
// scores over the training frames. Exact: numbers are what they were, up to rounding. With y = W^T y' + mean score and
// orthonormal new components,
//   mean += sum_k (mean score)_k basis_k,  weights' = R weights,  bias' = R (bias - mean score).
// Directions in which the old components repeat one another (to 1e-12) are gone. Returns the energies [K']: sum over
// frames of y'_k^2, in squared numbers, descending. They are what dropping a component costs.
std::vector<double> turnToPrincipalAxes(ClusterModel& cluster, std::span<const float> scores);

void keepComponents(ClusterModel& cluster, std::size_t count);  // the first ones

// Components of all clusters as a choice sees them.
struct ComponentCosts {
    std::vector<std::vector<double>> energies;  // [cluster, K] descending
    std::vector<double> bytes;                  // [cluster], of one component
};

struct ComponentChoice {
    std::vector<std::size_t> kept;  // [cluster], at least 1 where there was one
    double dropped_energy = 0, dropped_bytes = 0;
};

// Drops components in the order of energy lost for a byte saved, least first, until `bytes` are saved (or everything
// that can be dropped is) or the next would lose more than `energy` in all.
ComponentChoice dropForBytes(const ComponentCosts& costs, double bytes);
ComponentChoice dropForEnergy(const ComponentCosts& costs, double energy);

}  // namespace penumbra
