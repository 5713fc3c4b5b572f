#pragma once
// Compares the radiance of an approximation with the integral of light, binary visibility and the true BRDF
// (docs/formulas.md section 5, "shading error"), over all lights, occluders and views of the scenes.
#include <vector>

#include "fit/reflectance/shading_scenes.h"
#include "sh/brdf/brdf.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// Everything that is the same for every BRDF. Integrals over the hemisphere use a grid of Q directions: 64
// Gauss-Legendre heights times 256 azimuths.
struct ShadingTest {
    ShadingScenes scenes;
    std::vector<Vec3d> directions;  // [Q]
    std::vector<double> weights;    // [Q] steradians
    std::vector<double> light;      // [Q, lights] radiance times cosine times solid angle
    std::vector<double> open;       // [Q, occluders] 1 where the occluder leaves the sky open, else 0
    std::vector<double> moments;    // [occluders, kMaxOrder^2] b_i of sh/visibility_convention.h
};
ShadingTest makeShadingTest(const ShadingScenes& scenes, int threads);

// Returns the true radiance, [3, views, lights * occluders]. Where a lobe is too narrow for the grid that all views
// share, each view gets a grid of its own, dense around its mirror direction (brute_force_radiance.cpp).
std::vector<double> bruteForceRadiance(const ShadingTest& test, const RgbBrdf& brdf, int threads);

// Returns the relative RMSE, all channels together, of L = l . (f x v) against `truth`, which bruteForceRadiance()
// returned. `slices_of_views` holds the f of every view, [views, J^2, 3], where J = slice_order may be up to
// kMaxProductOrder. v is in `convention`, and the product is exact up to order J.
double shadingError(const ShadingTest& test, const std::vector<double>& truth, const Convention& convention,
                    const std::vector<double>& slices_of_views, int slice_order);

// Returns the f of every view, [views, rows, 3], as sum_e c[i, e, channel] y_(index[e])(view). `c` is [rows,
// index.size(), 3].
std::vector<double> slicesOfViews(const std::vector<Vec3d>& views, const std::vector<double>& c,
                                  const std::vector<int>& index);

}  // namespace penumbra
