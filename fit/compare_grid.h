#pragma once
// The fits that a comparison needs, each once, and what each came to.
#include <functional>
#include <string>
#include <vector>

#include "fit/fit_visibility.h"

namespace penumbra {

// One list for each thing that is varied. All combinations would be too many: every figure varies one thing and holds
// the others at the reference, which is the middle value of a list of numbers (of an even count, the upper) and the
// first convention.
struct CompareOptions {
    std::vector<ModelKind> models{kModelKinds.begin(), kModelKinds.end()};
    std::vector<FeatureKind> features{kFeatureKinds.begin(), kFeatureKinds.end()};
    std::vector<int> clusters{8, 16, 32, 64};                    // ascending
    std::vector<double> output_variances{0.8, 0.9, 0.95, 0.99};  // ascending
    std::vector<Convention> conventions;                         // the papers' A4, and D5
    std::vector<std::string> holdout;
    int threads = 0;

    int referenceClusters() const { return clusters[clusters.size() / 2]; }
    double referenceVariance() const { return output_variances[output_variances.size() / 2]; }
    Convention referenceConvention() const { return conventions.front(); }
};

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
    std::size_t clusters = 0;           // that came out
    double inputs = 0, components = 0;  // mean over clusters
    double bytes_per_vertex = 0;        // 32-bit numbers of the clusters over vertices
    double fit_seconds = 0;             // clusters, tangents, reading of the numbers, cross-validation and fit
    double evaluate_milliseconds = 0;   // a frame, one thread: predictNumbers(), median over frames
};

struct CompareInput {
    const VisibilityReader& reader;
    const PoseTable& poses;
    std::string file;  // for messages
};

// `progress` gets the share of this fit.
CompareFit runFit(const CompareInput& input, const FitOptions& options, const std::function<void(double)>& progress);

}  // namespace penumbra
