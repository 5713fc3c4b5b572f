#pragma once
// Measures the cosine that is multiplied into predicted visibility at run time (Nowrouzezahrai 2009, equation 14).
#include <vector>

#include "fit/papers/compare/compare_character.h"

namespace penumbra {

// Returns the relative error over the held-out frames of C (cosineMatrix()) times what `model` predicts, of the baked
// numbers of V max(s.N, 0): the quantity that a fit with kCosineForm predicts without C. The model is in
// convention A or B and in local frames, and the file has an order more than the model. Predictions are not clamped.
double cosineProductError(const CompareInput& input, const Model& model, int threads);

}  // namespace penumbra
