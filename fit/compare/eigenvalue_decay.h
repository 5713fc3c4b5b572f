#pragma once
// Measures how fast the eigenvalues of poses and of visibility fall (paper 002, figure 4), that is, how few numbers
// either needs.
#include <functional>
#include <string>
#include <vector>

#include "fit/compare/compare_character.h"

namespace penumbra {

struct EigenvalueDecay {
    std::string name;
    std::vector<double> shares;  // shares of the variance over training frames, descending

    std::size_t componentsFor(double share) const;  // at least 1
};

// Returns the decays of the pose vector and of the weighted bone features of a cluster (mean over clusters). What the
// file lacks is left out.
std::vector<EigenvalueDecay> inputDecays(const CompareInput& input, const CompareCharacter& character);
// Returns the decays of the numbers of all vertices together, as in paper 002, and of a cluster's numbers (mean over
// clusters). `progress` is told the share that is done.
std::vector<EigenvalueDecay> outputDecays(const CompareInput& input, const CompareCharacter& character,
                                          const CompareOptions& options, const std::function<void(double)>& progress);

}  // namespace penumbra
