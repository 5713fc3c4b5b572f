#pragma once
// Everything that the visibility fit needs to know. The defaults here are the documented ones, and no other place holds
// a default.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fit/visibility/local_coefficients.h"
#include "formats/common/far_by_rays.h"
#include "formats/stage/field_file.h"
#include "formats/stage/model_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Whether a composed model has near parts (docs/formulas.md, section 7). kAuto: where cross-validation prefers them.
enum class NearUse : std::uint8_t { kAuto, kOff, kOn };

struct FitOptions {
    ModelKind model = ModelKind::kAdditive;
    FeatureKind features = FeatureKind::kRelativeBones;
    int clusters = 0;  // 0: as many as mean-shift finds, or one for every kAutoClusterSize vertices if that is more
    int parts = 0;     // near-rigid parts of a deforming mesh; 0 lets fit/clusters/rigid_parts.h choose
    // Share of the variance of the weighted features that PCA keeps, in (0, 1]. 0 takes a default: 0.9 for angles, the
    // papers' value, and 0.99 for relative bones. There, blocked cross-validation of the linear model gains from every
    // input (relative error 0.716 at 0.9, 0.704 at 0.99). The neural model does not (0.661, 0.654 and 0.659 at 0.9,
    // 0.95 and 0.98), so its default is 0.95.
    double input_variance = 0;
    double output_variance = 0.95;     // share of the variance of a cluster's numbers that PCA keeps, in (0, 1]
    std::vector<std::string> holdout;  // clips that no step sees; only their errors are measured
    // Makes the model a composed one: `model` predicts what nearby parts hide, these fields what all others do. At most
    // one file is that of the character, the others are those of occluders. The visibility file must have local
    // moments.
    std::vector<FieldFile> fields;
    NearUse near = NearUse::kAuto;  // only composed models read it
    // At so many vertices the report holds the far parts of a composed model against rays (far_error.h); 0: at none.
    int compared_vertices = int(kComparedVertices);
    // The training frames, as clip names and times. Without a list, all frames that are not held out.
    std::optional<FrameList> train_frames;
    Convention convention;  // D5
    // For comparisons alone: other numbers than those of models that become files.
    const NumberForm* form = &kVisibilityForm;
    // The papers' mode for compression, where it is false: neural and additive models of visibility reproduce their
    // training frames without a prior. For comparisons.
    bool prior = true;
    // Bytes of numbers in memory at a time, at least one cluster's. With more clusters than fit, the file is read in
    // several passes. 0 takes a fifth of all numbers, but at least 32 and at most 256 MB, so that small files do not
    // cost much more memory than their size.
    std::size_t batch_bytes = 0;
    int threads = 0;  // 0 takes all cores; like batch_bytes it never changes the result
};

double inputVariance(const FitOptions& options);  // with the default resolved

// Relative bones; joint angles where a skeleton has one joint and no inputs beside it, which is relative to nothing.
FeatureKind defaultFeatures(const VisibilityHeader& header);

}  // namespace penumbra
