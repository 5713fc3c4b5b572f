#pragma once
// Fits the reflectance slices of a BRDF (docs/formulas.md section 3). F_i(o) is the integral over the hemisphere of
// f(wi, o) cos y_i dwi for i < J^2, and C = argmin sum over o of w_o z_o |F(o) - C y_even(o)|^2. This needs no 4D table
// and no SVD.
#include <vector>

#include "formats/brdf/slice_table.h"
#include "sh/brdf/brdf.h"

namespace penumbra {

struct SliceOrders {
    int slice_order = 5;  // J, from 1 to kMaxOrder
    int view_order = 5;   // from 1 to kMaxOrder
};

// Returns y_even of every view, [views, E].
std::vector<double> evenBasisTable(const std::vector<Vec3d>& views, int view_order);

// Returns C, row-major [J^2, E, 3], from a table.
std::vector<double> fitSlices(const SliceTable& table, const SliceOrders& orders);

// Returns the table that fits read. Throws InvalidInput when a lobe is too narrow for the finest grid.
SliceTable settledSlices(const RgbBrdf& source, int slice_order, int threads);

}  // namespace penumbra
