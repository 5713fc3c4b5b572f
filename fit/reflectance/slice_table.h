#pragma once
// The cosine-weighted BRDF as seen from many views, projected: F_i(o) = integral over the hemisphere of f(wi, o) cos
// y_i dwi, i < J^2, per colour channel. Views are a product grid: n_z Gauss-Legendre heights times 2 n_z azimuths from
// 0; n_z even.
#include <vector>

#include "sh/brdf.h"

namespace penumbra {

struct SliceTable {
    std::vector<double> slices;  // [views, J^2, 3]
    std::vector<Vec3d> views;
    std::vector<double> weights;  // [views], w_o z_o
    int view_n_z = 0;
    double refinement = 0;  // change of F in the last refinement, relative and cosine-weighted; 0 for a single grid
};

// The reference: all integrals on the same product grid as the views, with n_z = incident_n_z, and no use of symmetry
// but the BRDF's own.
SliceTable tabulateSlices(const RgbBrdf& brdf, int slice_order, int incident_n_z, int view_n_z, int threads);

constexpr double kSettled = 1e-3;
// Integrals on grids that are dense around the mirror direction of each view, refined view by view, all channels
// together, until `refinement` is below kSettled or the finest grid is reached.
SliceTable refinedSlices(const RgbBrdf& brdf, int slice_order, int threads);

// The largest directional albedo of any channel over some views, grazing ones included, where BRDFs gain energy first.
double largestAlbedo(const RgbBrdf& brdf, int threads);

}  // namespace penumbra
