#pragma once
// Singular value decomposition of a tabulated BRDF, docs/formulas.md section 3: f(wi, wo) cos_i = sum of U^b(wi)
// W^b(wo), best in a measure on both sides.
#include <vector>

#include "fit/numerics/matrix.h"
#include "sh/brdf.h"

namespace penumbra {

// Directions of the upper hemisphere: heights times azimuths 2 pi j / azimuths (a multiple of 4), a height a row.
struct DirectionGrid {
    std::vector<double> heights, weights;  // z; steradians of one direction of that height
    int azimuths = 0;

    std::size_t size() const { return heights.size() * std::size_t(azimuths); }
    Vec3d direction(std::size_t i) const;
    double weight(std::size_t i) const { return weights[i / std::size_t(azimuths)]; }
};
DirectionGrid gaussGrid(int heights, int azimuths);     // Gauss-Legendre heights
DirectionGrid latitudeGrid(int heights, int azimuths);  // centres of equal steps of the polar angle

// What the SVD is best in. On the side of the views the cosine keeps grazing spikes, which no grid resolves, from
// ruling; kNone weighs every entry of the table alike.
enum class ViewMeasure { kCosine, kSolidAngle, kNone };

struct BrdfTerms {              // of one channel
    std::vector<double> sigma;  // descending
    Matrix u, w;                // [k, directions]; u holds sigma
};

// The `count` first terms (fewer where the grid has fewer) of every channel; channels that differ by a factor share
// them, the factor in u. The table is split by the symmetry of the BRDF: by the frequency of the azimuth where it is
// isotropic (terms then come as cos and sin of equal singular value), by the four parities where it is orthotropic.
std::vector<BrdfTerms> brdfTerms(const RgbBrdf& brdf, const DirectionGrid& grid, ViewMeasure measure, int count,
                                 int threads);

// Factors that make the three channels of `values`, [N, 3], out of the one with the largest entry, whose factor is 1;
// empty where there are none (1e-12 of that entry). Zeros: 1, 0, 0.
struct ChannelFactors {
    int strongest = 0;
    std::vector<double> factors;  // [3] or empty
};
ChannelFactors channelFactors(const std::vector<double>& values);

}  // namespace penumbra
