#pragma once
// Singular value decomposition of a tabulated BRDF (docs/formulas.md section 3): f(wi, wo) cos_i = sum of U^b(wi)
// W^b(wo), the best approximation in a measure on either side.
#include <vector>

#include "fit/numerics/matrix.h"
#include "sh/brdf/brdf.h"

namespace penumbra {

// Directions of the upper hemisphere: heights times azimuths 2 pi j / azimuths, ordered height by height. The number of
// azimuths is a multiple of 4.
struct DirectionGrid {
    std::vector<double> heights, weights;  // z, and the steradians of one direction of each height
    int azimuths = 0;

    std::size_t size() const { return heights.size() * std::size_t(azimuths); }
    Vec3d direction(std::size_t i) const;
    double weight(std::size_t i) const { return weights[i / std::size_t(azimuths)]; }
};
DirectionGrid gaussGrid(int heights, int azimuths);     // heights are Gauss-Legendre nodes
DirectionGrid latitudeGrid(int heights, int azimuths);  // heights are centers of equal steps of the polar angle

// The measure in which the SVD is best. On the side of the views, the cosine keeps grazing spikes, which no grid
// resolves, from ruling the result. kNone gives every entry of the table the same weight.
enum class ViewMeasure { kCosine, kSolidAngle, kNone };

// The terms of one channel.
struct BrdfTerms {
    std::vector<double> sigma;  // descending
    Matrix u, w;                // [k, directions]; u contains sigma
};

// Returns the first `count` terms of every channel, or fewer where the grid has fewer. Channels that differ only by a
// factor share their terms, and u takes the factor. The symmetry of the BRDF splits the table: an isotropic one by the
// frequency of the azimuth, where terms come as cos and sin with equal singular values; an orthotropic one by its four
// parities.
std::vector<BrdfTerms> brdfTerms(const RgbBrdf& brdf, const DirectionGrid& grid, ViewMeasure measure, int count,
                                 int threads);

// Factors by which the channel with the largest entry gives all three channels of `values` [N, 3]. Its own factor is 1.
// `factors` is empty when there are none within 1e-12 of that entry. When all values are zero they are 1, 0, 0.
struct ChannelFactors {
    int strongest = 0;
    std::vector<double> factors;  // [3] or empty
};
ChannelFactors channelFactors(const std::vector<double>& values);

}  // namespace penumbra
