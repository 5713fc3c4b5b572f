#include "runtime/shade/surface_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

// Returns the SH coefficients of s_x / pi or s_y / pi above the horizon. In the azimuth four points integrate a product
// of two functions of |m| = 1 exactly; along z it is the midpoint rule.
std::vector<float> slopeCoefficients(int order, int axis) {
    constexpr int kRows = 4096;
    std::vector<double> sums(std::size_t(coefficientCount(order)), 0.0), y(sums.size());
    for (int row = 0; row < kRows; ++row) {
        const double z = (row + 0.5) / kRows, r = std::sqrt(1 - z * z);
        for (int turn = 0; turn < 4; ++turn) {
            const double angle = (turn + 0.5) * std::numbers::pi / 2;
            const Vec3d s{r * std::cos(angle), r * std::sin(angle), z};
            evalBasis(order, s, y);
            for (std::size_t i = 0; i < y.size(); ++i) sums[i] += y[i] * s[axis] / (2.0 * kRows);
        }
    }
    // At these points, terms with another |m| than 1 are aliases only.
    for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m)
            if (m != (axis == 0 ? 1 : -1)) sums[std::size_t(shIndex(l, m))] = 0;
    return {sums.begin(), sums.end()};
}

}  // namespace

SurfaceTerms surfaceTermsOf(const SurfaceView& surface) {
    SurfaceTerms terms;
    for (const SlotSurface& slot : surface.slots) {
        if (slot.use(TextureRole::kNormal).any()) terms.slopes = 3;
        terms.steps = std::max<std::size_t>(terms.steps, slot.materials.steps);
    }
    return terms;
}

std::vector<float> slopeSlices(const Convention& convention, int axis) {
    std::vector<float> slices = slopeCoefficients(convention.order, axis);
    for (float& c : slices) c *= 2 * std::sqrt(std::numbers::pi_v<float>);  // the view function is y_0
    return slices;
}

MaterialView slopeMaterial(const Convention& convention, std::span<const float> slices) {
    MaterialView material;
    material.slice_order = convention.order;
    material.view_order = 1;
    material.channels = 1;
    material.color = {1, 1, 1};
    material.slices = slices;
    return material;
}

MaterialTables slopeTables(const Convention& convention, int light_order, int axis) {
    const std::vector<float> slices = slopeSlices(convention, axis);
    MaterialTables tables(convention, light_order, slopeMaterial(convention, slices), Reflectance::kSlices);
    tables.allowNegative();
    return tables;
}

}  // namespace penumbra
