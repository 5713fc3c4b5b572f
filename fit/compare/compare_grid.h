#pragma once
// The fits that a comparison needs, each once, and what each came to.
#include <functional>
#include <string>
#include <vector>

#include "fit/compare/joint_sweep.h"
#include "fit/visibility/fit_visibility.h"

namespace penumbra {

// A model on features, at the reference.
FitOptions referenceFit(const CompareOptions& options, ModelKind model, FeatureKind features);
// Figures 8 and 9 of paper 000 take convention A: of the reference's order, one less where the file has no moments
// above.
Convention paperConvention(const CompareOptions& options, int file_order);

// In the order in which they run: model by model, features by features; no two alike.
std::vector<FitOptions> makeGrid(const CompareOptions& options, int file_order);
bool sameFit(const FitOptions& a, const FitOptions& b);
std::string labelOf(ModelKind model, FeatureKind features);  // "linear, relative bones"
std::string describe(const FitOptions& fit);                 // "linear, relative bones, 32 clusters, 0.95, A4"

struct CompareFit {
    FitOptions options;
    FitReport report;
    std::vector<ClipError> clip_errors;
    std::size_t clusters = 0;           // that came out
    double inputs = 0, components = 0;  // mean over clusters
    double bytes_per_vertex = 0;        // 32-bit numbers of the clusters over vertices
    double fit_seconds = 0;             // clusters, tangents, reading of the numbers, cross-validation and fit
    std::vector<double> turn_ambient;   // E along the comparison's joint sweep; empty: not asked for
    double evaluate_milliseconds = 0;   // a frame, one thread: predictNumbers(), median over frames
};

// `sweep` may be null. `progress` gets the share of this fit.
CompareFit runFit(const CompareInput& input, const FitOptions& options, const JointSweep* sweep,
                  const std::function<void(double)>& progress);

}  // namespace penumbra
