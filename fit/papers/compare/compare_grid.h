#pragma once
// Lists the fits that a comparison needs, each once, and measures them.
#include <chrono>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "fit/papers/compare/joint_sweep.h"
#include "fit/visibility/fit_visibility.h"

namespace penumbra {

// Returns the options of a model on some features with everything else at the reference.
FitOptions referenceFit(const CompareOptions& options, ModelKind model, FeatureKind features);
// Returns the additive model of relative bones in the first mirrored convention of the list (else D5, or the file's
// order if that is less), and the same as the local model of a composed one; options.fields has some for the latter.
FitOptions mirroredAdditiveFit(const CompareOptions& options, int file_order);
FitOptions composedFit(const CompareOptions& options, int file_order);
// Returns the convention for figures 8 and 9 of Nowrouzezahrai 2009, which take convention A. It has the order of the
// reference, or one less where the file has no higher moments.
Convention paperConvention(const CompareOptions& options, int file_order);

// Tells which models the grid has without prior, too. Those of feature vectors have fits of their own for that
// (feature_vectors.h).
bool compressesWithoutPrior(ModelKind model);
// Returns the fits in the order in which they run, model by model and for each model features by features. No two are
// alike.
std::vector<FitOptions> makeGrid(const CompareOptions& options, int file_order);
bool sameFit(const FitOptions& a, const FitOptions& b);
std::string wordsOf(FeatureKind features);                   // for example "relative bones"
std::string labelOf(ModelKind model, FeatureKind features);  // for example "linear, relative bones"
std::string labelOf(const FitOptions& fit);                  // the same, or for example "composed, additive, D5"
std::string describe(const FitOptions& fit);  // for example "linear, relative bones, 32 clusters, 0.95, A4"

double secondsSince(std::chrono::steady_clock::time_point start);
// Returns how many 32-bit numbers the clusters of a model have, those of its residual too.
std::size_t numberCount(const Model& model);

struct CompareFit {
    FitOptions options;
    FitReport report;
    std::vector<ClipError> clip_errors;
    std::size_t clusters = 0;                      // number of clusters that came out
    double inputs = 0, components = 0, units = 0;  // means over the clusters
    // Size of the clusters' 32-bit numbers, and of the fields of a composed model, divided by the number of vertices.
    double bytes_per_vertex = 0;
    double fit_seconds = 0;            // clusters, tangents, reading of the numbers, cross-validation and fit
    std::vector<double> turn_ambient;  // E along the comparison's joint sweep; empty when there is none
    // The error of the cosine multiplied into predictions (cosine_product.h). Only of the fits of figure 8, else NaN.
    double cosine_product_error = std::numeric_limits<double>::quiet_NaN();
    double evaluate_milliseconds = 0;  // Predictor::predict() for a frame on one thread, median over frames
};

// Runs one fit and measures it. `sweep` may be null. `progress` is told the share of this fit that is done.
CompareFit runFit(const CompareInput& input, const FitOptions& options, const JointSweep* sweep,
                  const std::function<void(double)>& progress);

}  // namespace penumbra
