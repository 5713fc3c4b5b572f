#pragma once
// What the visibility fit needs to know. The defaults here are the documented ones; nothing else holds a default.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fit/visibility/local_numbers.h"
#include "formats/stage/model_file.h"

namespace penumbra {

struct FitOptions {
    ModelKind model = ModelKind::kAdditive;
    FeatureKind features = FeatureKind::kRelativeBones;
    int clusters = 0;  // 0: what mean-shift finds, or one for every kAutoClusterSize vertices if more
    int parts = 0;     // near-rigid parts of a deforming mesh; 0: fit/clusters/rigid_parts.h chooses
    // Of the (weighted) features that PCA keeps, in (0, 1]; 0: 0.9 for angles, the papers' value, and 0.99 for
    // relative bones, where blocked cross-validation of the linear model gains from every input (0.716 at 0.9, 0.704 at
    // 0.99) and that of the neural one does not (0.661, 0.654 and 0.659 at 0.9, 0.95, 0.98): 0.95 for it.
    double input_variance = 0;
    double output_variance = 0.95;     // of the numbers of a cluster that PCA keeps, in (0, 1]
    std::vector<std::string> holdout;  // clips that no step sees; errors only
    // Training frames: those of this list (clip names and times) alone; nothing: all that are not held out.
    std::optional<FrameList> train_frames;
    Convention convention;  // D5
    // For comparisons; a model of the second kind of either is never written to a file. Convention A or B only, and not
    // both at once.
    Target target = Target::kVisibility;
    Frame frame = Frame::kLocal;
    // Errors of predictions that are moved to where E lies in [0, 1], as predictNumbers() and the run-time give them.
    // False only in comparisons; in the model frame there is no other way, as the weights of E turn with the normal.
    bool clamp = true;
    // Of numbers in memory at a time, at least one cluster's: more clusters take more passes over the file.
    // 0: a fifth of all numbers, within 32 and 256 MB, so that small files do not cost much more memory than their
    // size.
    std::size_t batch_bytes = 0;
    int threads = 0;  // 0: all cores; like batch_bytes it never changes the result
};

double inputVariance(const FitOptions& options);  // with the default resolved

// Empty when the options can be used, else one sentence that names the option, its range and the value given.
std::string findProblem(const FitOptions& options);

}  // namespace penumbra
