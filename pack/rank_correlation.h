#pragma once
#include <span>

namespace penumbra {

// Spearman's: the correlation of the ranks, equal values at their mean rank. NaN for fewer than two values, or where
// all of one side are equal. Both of one length.
double rankCorrelation(std::span<const double> a, std::span<const double> b);

}  // namespace penumbra
