#pragma once
// Chooses the near parts of a composed model (docs/formulas.md, section 7, "The fit of near parts").
#include <optional>

#include "fit/visibility/fit_batches.h"

namespace penumbra {

// Gives the model near parts with gains of 1, if they are asked for (FitOptions::near) or if cross-validation prefers
// them, and returns what it saw where it had to. A deforming mesh never has any.
std::optional<NearReport> chooseNearParts(const FitJob& job, Model& model);

}  // namespace penumbra
