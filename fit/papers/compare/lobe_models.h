#pragma once
// Measures Nowrouzezahrai 2008's own model of visibility beside linear models of the SH that its lobes stand for.
// `penumbra-fit visibility --model zh-lobes` writes such a model of all vertices to a file. docs/formulas.md tells why
// no other program takes it: three lobes have as many numbers as the SH, and their axes are not continuous in the pose.
#include <functional>
#include <string>
#include <vector>

#include "fit/papers/compare/compare_character.h"
#include "fit/papers/lobes/lobe_maps.h"

namespace penumbra {

struct ComparedLobes {
    std::string name;
    double fitted = 0;       // relative error of the lobes before the regression, over all frames
    double ridge = 0;        // LobeProblem::ridge
    FrameSpread visibility;  // held out, of the numbers of B; NaN where the model has none
    FrameSpread cosine;      // moments of V max(cos, 0); the cosine is added to the prediction again
};

struct LobeComparison {
    std::size_t vertices = 0, inputs = 0;  // size of the sample; number of principal components of the joint angles
                                           // that are kept
    int order = 0;
    std::vector<ComparedLobes> models;  // SH, SH with the cosine in the data, then options.lobes
};

// The vertices are those that the ridge of a model is chosen with (sampleVertices()). Needs a file of order 2 or more
// and joint angles.
LobeComparison compareLobes(const CompareInput& input, const CompareCharacter& character, const CompareOptions& options,
                            const std::function<void(double)>& progress);

}  // namespace penumbra
