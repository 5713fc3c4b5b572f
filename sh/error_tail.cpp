#include "sh/error_tail.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace penumbra {

void ErrorTail::add(double error) {
    assert(!(error < 0));
    ++count_;
    if (std::isnan(error) || error > largest_) largest_ = error;  // keeps NaN
    if (std::isnan(error)) return;
    const auto bin = std::size_t(std::ceil(std::min(error, 2.0) * double(kBins)));
    const std::size_t kept = std::min(bin, kBins + 1);
    if (counts_.size() <= kept) counts_.resize(kept + 1);
    ++counts_[kept];
}

void ErrorTail::add(const ErrorTail& other) {
    count_ += other.count_;
    if (std::isnan(other.largest_) || other.largest_ > largest_) largest_ = other.largest_;
    if (counts_.size() < other.counts_.size()) counts_.resize(other.counts_.size());
    for (std::size_t k = 0; k < other.counts_.size(); ++k) counts_[k] += other.counts_[k];
}

double ErrorTail::quantile(double share) const {
    assert(share > 0 && share <= 1);
    if (count_ == 0 || std::isnan(largest_)) return std::numeric_limits<double>::quiet_NaN();
    const auto wanted = std::uint64_t(std::ceil(share * double(count_)));
    std::uint64_t below = 0;
    for (std::size_t k = 0; k <= kBins && k < counts_.size(); ++k) {
        below += counts_[k];
        if (below >= wanted) return std::min(double(k) / double(kBins), largest_);
    }
    return largest_;
}

}  // namespace penumbra
