#pragma once
// How fast the eigenvalues of poses and of visibility fall (paper 002, figure 4): how few numbers either needs.
#include <functional>
#include <string>
#include <vector>

#include "fit/compare/compare_character.h"

namespace penumbra {

struct EigenvalueDecay {
    std::string name;
    std::vector<double> shares;  // of the variance over training frames, descending

    std::size_t componentsFor(double share) const;  // at least 1
};

// The pose vector; the weighted bone features of a cluster, mean over clusters. What the file lacks is left out.
std::vector<EigenvalueDecay> inputDecays(const CompareInput& input, const CompareCharacter& character);
// The numbers of all vertices together, as in paper 002; of a cluster, mean over clusters. `progress` gets the share.
std::vector<EigenvalueDecay> outputDecays(const CompareInput& input, const CompareCharacter& character,
                                          const CompareOptions& options, const std::function<void(double)>& progress);

}  // namespace penumbra
