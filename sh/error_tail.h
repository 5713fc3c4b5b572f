#pragma once
// Tells which error a share of many errors does not exceed, in bounded memory.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace penumbra {

// The share of the worst places that figures of E leave out: one of 1,000 (vertex, frame) pairs.
constexpr double kTailShare = 0.999;

// Counts errors in bins of 1 / kBins. What is above 1 shares one bin.
class ErrorTail {
public:
    static constexpr std::size_t kBins = 2048;

    void add(double error);  // >= 0, or NaN
    void add(const ErrorTail& other);
    // The largest error, exactly. 0 of no errors, NaN where one was NaN.
    double largest() const { return largest_; }
    // Returns the smallest multiple of 1 / kBins that at least `share` of the errors, in (0, 1], do not exceed, or the
    // largest error where that is smaller. So the result is at most 1 / kBins above the exact one, unless that is above
    // 1. NaN of no errors, and where one was NaN.
    double quantile(double share) const;

private:
    std::vector<std::uint64_t> counts_;  // [0]: of 0; [k]: of ((k - 1) / kBins, k / kBins]; up to the last one in use
    std::uint64_t count_ = 0;
    double largest_ = 0;
};

}  // namespace penumbra
