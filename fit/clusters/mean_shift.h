#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "formats/common/mesh.h"

namespace penumbra {

// Every point [n, D] climbs the Gaussian kernel density (standard deviation `bandwidth`) of all points, which count as
// often as `counts` says; those that reach one mode are a cluster (Comaniciu and Meer 2002). The cost is n squared.
// Result: the number of each point's mode.
std::vector<std::uint32_t> meanShift(const MatrixF& points, std::span<const double> counts, double bandwidth,
                                     int threads);

// Two vertices that follow one bone each are sqrt(2) apart, a half-and-half one 0.71 from both: 0.2 keeps these three
// apart and joins what a smooth falloff blurs.
constexpr double kSkinWeightBandwidth = 0.2;

// meanShift() of vertices by their skinning weights, as points of the J-dimensional simplex. Weights are first put into
// bins of 1/8, each bin standing for its members by their mean and count, so the cost is the number of different bins
// squared. Result: a label per vertex, dense, in order of first use.
std::vector<std::uint32_t> meanShiftSkinWeights(const Skin& skin, double bandwidth = kSkinWeightBandwidth,
                                                int threads = 0);

}  // namespace penumbra
