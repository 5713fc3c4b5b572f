#pragma once
// Projects lat-long pictures row by row, so that large ones need not be in memory. project_map.h has the plain sums for
// whole pictures; these take a tenth of their time and agree to 1e-6 of the largest coefficient.
#include <array>
#include <vector>

#include "formats/image/project_disc.h"
#include "formats/image/project_map.h"

namespace penumbra {

// --- What both ways share
// --------------------------------------------------------------------------------------------- The frame here has the
// picture's pole as z: s' = (sin t cos q, sin t sin q, cos t) with q = -p (latLongDirection).

// Sums over the pixels of a row: radiance times the integrals of cos mq dq and sin mq dq.
struct RowMoments {
    std::array<Vec3d, kMaxOrder> cosine{}, sine{};
};
// The integrals of cos mq and sin mq over the pixels of a row, which all rows share: their sines and cosines take ten
// times as long as all the rest.
struct RowWaves {
    std::array<std::vector<double>, kMaxOrder> cosine, sine;  // [order][width]
};
RowWaves wavesOfRow(int pixels, int order);
// Adds a row between the polar angles t0 and t1.
void addRowMoments(const RowMoments& moments, double t0, double t1, int order, PartialProjection& sum);
// Adds up parts in their order, and turns them from the layout's frame to the model frame.
MapProjection joinProjections(std::span<const PartialProjection> parts, MapLayout layout, int order);

// --- Row by row
// -------------------------------------------------------------------------------------------------------
class RowProjection {
public:
    RowProjection(PictureSides sides, int order);
    // Adds row `row` (0 at the top), [width] of each colour.
    void add(int row, const std::array<const float*, 3>& color);
    MapProjection result() const { return joinProjections({&sum_, 1}, MapLayout::kLatLong, order_); }

private:
    void fold(const float* row);
    RowMoments foldedMoments(const std::array<const float*, 3>& color);
    RowMoments plainMoments(const std::array<const float*, 3>& color) const;

    PictureSides sides_;
    int order_;
    RowWaves waves_;
    std::array<std::vector<float>, kMaxOrder> cosine_, sine_;  // for a quarter of a row
    std::array<std::array<std::vector<float>, 2>, 2> folded_;  // [m odd][of sines]: a quarter of a row
    std::vector<float> both_;                                  // half of a row: f(p) with f(p + pi)
    PartialProjection sum_;
};

}  // namespace penumbra
