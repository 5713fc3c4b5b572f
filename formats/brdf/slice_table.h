#pragma once
// Tabulates the cosine-weighted BRDF as seen from many views, projected on SH: F_i(o) = integral over the hemisphere of
// f(wi, o) cos y_i dwi for i < J^2, for each colour channel. Views form a product grid: n_z Gauss-Legendre heights
// times 2 n_z azimuths, which start at 0. n_z is even.
#include <vector>

#include "sh/brdf/brdf.h"

namespace penumbra {

constexpr int kSliceChannels = 3;  // colours

struct SliceTable {
    std::vector<double> slices;  // [views, J^2, 3]
    std::vector<Vec3d> views;
    std::vector<double> weights;  // [views] w_o z_o
    int view_n_z = 0;
    double refinement = 0;  // relative change of F in the last refinement, cosine-weighted; 0 for a single grid
};

// The reference: takes all integrals on one product grid with n_z = incident_n_z. It uses no symmetry but that of the
// BRDF.
SliceTable tabulateSlices(const RgbBrdf& brdf, int slice_order, int incident_n_z, int view_n_z, int threads);

// Integrals are accurate enough when the last refinement changed F by less than this.
constexpr double kSettled = 1e-3;
// Takes integrals on grids that are dense around the mirror direction of each view. The grids are refined view by view,
// all channels together, until `refinement` is below kSettled or the finest grid is reached.
SliceTable refinedSlices(const RgbBrdf& brdf, int slice_order, int threads);

// Returns the largest directional albedo of any channel over some views. Grazing views are among them, because BRDFs
// gain energy there first.
double largestAlbedo(const RgbBrdf& brdf, int threads);

}  // namespace penumbra
