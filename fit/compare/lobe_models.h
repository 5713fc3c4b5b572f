#pragma once
// Measures paper 003's own model of visibility: zonal lobes at every vertex, whose parameters are linear in the joint
// angles. It is a reference that no file holds. docs/formulas.md tells why: three lobes have as many numbers as the
// SH that they stand for, and their axes are not continuous in the pose.
#include <functional>
#include <string>
#include <vector>

#include "fit/compare/compare_character.h"

namespace penumbra {

// The mean over held-out frames of the relative error |v^ - v| / |v| of all vertices together, and its deviation.
struct HeldOutErrors {
    double mean = 0, deviation = 0;
};

struct LobeModel {
    std::string name;
    double fitted = 0;         // relative error of the lobes before the regression, over all frames
    double ridge = 0;          // weight of the squares of their coefficients
    HeldOutErrors visibility;  // of the numbers of B; NaN where the model has none
    HeldOutErrors cosine;      // of the moments of V max(cos, 0), where the cosine is added again to the prediction
};

struct LobeComparison {
    std::size_t vertices = 0, inputs = 0;  // of the sample; kept principal components of the joint angles
    int order = 0;
    std::vector<LobeModel> models;  // SH, SH with the cosine in the data, then options.lobes
};

// Fits the lobes of vertex and frame jointly, from the axes of the vertex' mean visibility, so that they follow the
// pose without jumps where they can. Folds of the training frames choose the ridge of every number of lobes, as
// makeFolds() cuts them. The vertices are a sample of at most kLobeVertices. Needs a file of order 2 or
// more and joint angles.
constexpr std::size_t kLobeVertices = 64;
LobeComparison compareLobes(const CompareInput& input, const CompareCharacter& character, const CompareOptions& options,
                            const std::function<void(double)>& progress);

}  // namespace penumbra
