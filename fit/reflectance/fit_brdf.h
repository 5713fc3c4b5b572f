#pragma once
// Fits the reflectance slices of a BRDF (docs/formulas.md section 3). F_i(o) is the integral over the hemisphere of
// f(wi, o) cos y_i dwi for i < J^2, and C = argmin sum over o of w_o z_o |F(o) - C y_even(o)|^2. This needs no 4D table
// and no SVD.
#include <vector>

#include "fit/reflectance/slice_table.h"
#include "formats/stage/brdf_file.h"
#include "sh/brdf/brdf.h"

namespace penumbra {

struct SliceOrders {
    int slice_order = 5;  // J, from 1 to kMaxOrder
    int view_order = 5;   // from 1 to kMaxOrder
};

// Returns C, row-major [J^2, E, 3], from a table.
std::vector<double> fitSlices(const SliceTable& table, const SliceOrders& orders);

// Returns the table that fits read. Throws InvalidInput when a lobe is too narrow for the finest grid.
SliceTable settledSlices(const RgbBrdf& source, int slice_order, int threads);

// Fits a BRDF. The provenance is left to the caller. Throws as settledSlices() does. The result has these `errors`,
// over all channels where none is named:
//
// - fit: sqrt(sum w z |F - C y|^2 / sum w z |F|^2).
// - refinement: the last change of F in the same measure.
// - albedo_r, albedo_g, albedo_b: the mean directional albedo, where views are weighted by their cosine.
// - albedo_max: the largest directional albedo of any view, down to 0.1 degrees above the horizon.
BrdfFile fitBrdf(const RgbBrdf& source, const SliceOrders& orders, int threads);

}  // namespace penumbra
