#pragma once
#include <span>

namespace penumbra {

// Returns Spearman's correlation: that of the ranks, where equal values share their mean rank. NaN for fewer than two
// values, or where all values of one side are equal. Both sides have the same length.
double rankCorrelation(std::span<const double> a, std::span<const double> b);

}  // namespace penumbra
