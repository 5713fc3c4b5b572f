#pragma once
// Fits the slices of a material at steps of its parameter, between which the run time interpolates them.
#include "fit/reflectance/fit_brdf.h"
#include "sh/brdf/brdf_range.h"

namespace penumbra {

// Steps are dense enough when slices in the middle between any two differ by less than this from what interpolation
// gives. It is a tenth of the error that slices of a glossy material have anyway (docs/accuracy.md).
constexpr double kMaxStepError = 5e-3;

// Returns slices at the ends of the range, in its middle and at as many steps between them as kMaxStepError asks for;
// at most `most_steps`, at least 3. Throws as settledSlices() does.
BrdfSteps fitSteps(const BrdfRange& range, const SliceOrders& orders, int most_steps, int threads);

}  // namespace penumbra
