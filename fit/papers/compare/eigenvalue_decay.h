#pragma once
// Measures how fast the eigenvalues of poses and of visibility fall (Nowrouzezahrai 2007, figure 4), that is, how few
// numbers either needs.
#include <functional>
#include <string>
#include <vector>

#include "fit/papers/compare/compare_character.h"

namespace penumbra {

struct EigenvalueDecay {
    std::string name;
    std::vector<double> shares;  // shares of the variance over training frames, descending; all, or the largest

    std::size_t componentsFor(double share) const;  // at least 1, at most those that are known
    bool reaches(double share) const;               // true when the known components have that share together
};

// Returns each value's share of a total. The result is empty where the total is 0.
std::vector<double> sharesOf(std::vector<double> values, double total);
// Returns the decays of the pose vector and of the weighted bone features of a cluster (mean over clusters). What the
// file lacks is left out.
std::vector<EigenvalueDecay> inputDecays(const CompareInput& input, const CompareCharacter& character);
// Returns the decays of the numbers of all vertices together, with a row a pose and with a row a pose and number, and
// of a cluster's numbers (mean over clusters). The second is what Nowrouzezahrai 2007 stacks: its rows have one number
// a vertex. Only its 200 largest eigenvalues are computed. `progress` is told the share that is done.
std::vector<EigenvalueDecay> outputDecays(const CompareInput& input, const CompareCharacter& character,
                                          const CompareOptions& options, const std::function<void(double)>& progress);

}  // namespace penumbra
