#pragma once
// Fits the reflectance slices of a BRDF and measures the fit.
#include "formats/brdf/fit_slices.h"
#include "formats/stage/brdf_file.h"
#include "sh/brdf/brdf.h"

namespace penumbra {

// Fits a BRDF. The provenance is left to the caller. Throws as settledSlices() does. The result has these `errors`,
// over all channels where none is named:
//
// - fit: sqrt(sum w z |F - C y|^2 / sum w z |F|^2).
// - refinement: the last change of F in the same measure.
// - albedo_r, albedo_g, albedo_b: the mean directional albedo, where views are weighted by their cosine.
// - albedo_max: the largest directional albedo of any view, down to 0.1 degrees above the horizon.
BrdfFile fitBrdf(const RgbBrdf& source, const SliceOrders& orders, int threads);

}  // namespace penumbra
