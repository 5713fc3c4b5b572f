#pragma once
// Chooses the near parts of a composed model (docs/formulas.md, section 7, "The fit of near parts").
#include <optional>

#include "fit/visibility/fit_batches.h"

namespace penumbra {

struct NearChoice {
    HiddenVertices hidden = HiddenVertices::kOpened;
    std::optional<NearReport> report;  // where cross-validation chose
};
// Gives the model near parts with gains of 1, if they are asked for (FitOptions::near) or if cross-validation prefers
// them. Vertices that other parts hide are opened unless cross-validation shows that it costs more than a percent of
// the error. A deforming mesh never has near parts.
NearChoice chooseNearParts(const FitJob& job, Model& model);

}  // namespace penumbra
