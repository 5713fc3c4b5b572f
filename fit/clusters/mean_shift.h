#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "formats/common/mesh.h"

namespace penumbra {

// Clusters points [n, D] by mean-shift (Comaniciu and Meer 2002). Every point climbs the Gaussian kernel density of all
// points, whose standard deviation is `bandwidth`; each point counts as often as `counts` [n] says. Points that reach
// the same mode form a cluster. Returns the number of each point's mode, [n]. The cost is proportional to n squared.
// The result is the same for any number of threads.
std::vector<std::uint32_t> meanShift(const MatrixF& points, std::span<const double> counts, double bandwidth,
                                     int threads);

// Two vertices that each follow one bone alone are sqrt(2) apart, and a vertex that follows both by half is 0.71 from
// either. A bandwidth of 0.2 keeps these three apart and joins what a smooth falloff blurs.
constexpr double kSkinWeightBandwidth = 0.2;

// Clusters vertices by their skinning weights, as points of the J-dimensional simplex, with meanShift(). Weights are
// first put into bins of 1/8, and the mean and count of each bin stand for its members. The cost is therefore the
// square of the number of different bins, not of vertices. Returns a label for each vertex; labels are dense and in
// order of first use.
std::vector<std::uint32_t> meanShiftSkinWeights(const Skin& skin, double bandwidth = kSkinWeightBandwidth,
                                                int threads = 0);

}  // namespace penumbra
