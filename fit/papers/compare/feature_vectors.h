#pragma once
// Fits linear models of higher-order feature vectors, with and without the prior (Nowrouzezahrai 2009, section 5.3 and
// figure 7).
#include <functional>
#include <string>
#include <vector>

#include "fit/papers/compare/compare_character.h"
#include "fit/papers/compare/joint_sweep.h"
#include "fit/visibility/fit_visibility.h"

namespace penumbra {

struct VectorFit {
    FeatureKind features = FeatureKind::kJointAngles;
    int degree = 1;                // 1 linear, 2 quadratic, 3 cubic
    bool prior = true;             // false: plain least squares, the papers' compression mode
    ErrorFigures train, held_out;  // predictions are not clamped; the ambient errors are NaN
    std::size_t clusters = 0;
    double inputs = 0, components = 0, units = 0;  // means over the clusters
    double bytes_per_vertex = 0;
    std::vector<double> turn_ambient;  // E along the joint sweep; empty when there is none
};

constexpr int kMaxDegree = 3;
const char* nameOfDegree(int degree);  // linear, quadratic or cubic

// Fits every degree on all features of the options at the reference, with and without the prior. `sweep` may be null.
// `progress` is told the share that is done.
std::vector<VectorFit> fitFeatureVectors(const CompareInput& input, const CompareCharacter& character,
                                         const CompareOptions& options, const JointSweep* sweep,
                                         const std::function<void(double)>& progress);

// Returns the inputs [n, I] and all products of two (degree 2), and of three of the first 21 (degree 3). More would be
// more units than there are frames to tell them apart.
Matrix polynomialInputs(const Matrix& inputs, int degree);

}  // namespace penumbra
