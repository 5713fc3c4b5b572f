#pragma once
// Compares the radiance of an approximation with the integral of light, binary visibility and the true BRDF
// (docs/formulas.md section 5, "shading error"), over all lights, occluders and views of the scenes.
#include <span>
#include <vector>

#include "fit/reflectance/shading_scenes.h"
#include "formats/stage/brdf_file.h"
#include "sh/brdf/brdf.h"
#include "sh/brdf/brdf_lobe.h"
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

// The scenes of a test, and what a BRDF truly shows of them.
struct ShadingTruth {
    ShadingTest test;
    std::vector<double> radiance;  // result of bruteForceRadiance()
};
ShadingTruth shadingTruth(const RgbBrdf& brdf, int threads);  // for the reference scenes

// Returns the relative RMSE, all channels together, of L = l . (f x v) against the truth. `slices_of_views` holds the f
// of every view, [views, J^2, 3], where J = slice_order may be up to kMaxProductOrder. v is in `convention`, and the
// product is exact up to order J.
double shadingError(const ShadingTruth& truth, const Convention& convention, const std::vector<double>& slices_of_views,
                    int slice_order);

// Returns the f of every view, [views, rows, 3], as sum_e c[i, e, channel] y_(index[e])(view). `c` is [rows,
// index.size(), 3].
std::vector<double> slicesOfViews(const std::vector<Vec3d>& views, const std::vector<double>& c,
                                  const std::vector<int>& index);

// Adds the shading errors of the slices to brdf.errors: shading_d5 and shading_a4. The light has order 4.
void measureShading(const ShadingTruth& truth, BrdfFile& brdf);
// Returns the relative RMSE of the true radiance of lobes against the truth of the material that they stand for. No
// lobe may be a mirror.
double lobeError(const ShadingTruth& truth, std::span<const BrdfLobe> lobes, int threads);

}  // namespace penumbra
