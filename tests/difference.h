#pragma once
// Differences of numbers, for tests. The compared numbers must be finite, of the same count on both sides, and not
// empty. Otherwise the running test fails, whatever it expects of the result, and the result is infinite. A plain
// `worst = std::max(worst, std::abs(a - b))` would pass NaN and empty arrays.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <ostream>
#include <ranges>
#include <type_traits>

namespace penumbra {

// The largest of the values that were added. Reading it fails the test if there were none, or if one was not finite.
class Largest {
public:
    void add(double value) {
        if (!std::isfinite(value)) largest_ = std::numeric_limits<double>::infinity();
        if (value > largest_) largest_ = value;
    }
    double value() const {
        if (std::isfinite(largest_)) return largest_;
        ADD_FAILURE() << (largest_ > 0 ? "a value is NaN or infinite" : "there is no value");
        return std::numeric_limits<double>::infinity();
    }
    operator double() const { return value(); }
    friend std::ostream& operator<<(std::ostream& out, const Largest& largest) { return out << largest.largest_; }

private:
    double largest_ = -std::numeric_limits<double>::infinity();
};

// Calls f(x, y) for the numbers of a and b, which are numbers, vectors, or ranges of these. Returns whether all sizes
// were the same.
template <class A, class B, class F>
bool forEachPair(const A& a, const B& b, const F& f) {
    if constexpr (std::is_arithmetic_v<A>) {
        f(double(a), double(b));
        return true;
    } else if constexpr (std::ranges::range<A>) {
        if (std::ranges::size(a) != std::ranges::size(b)) return false;
        bool same = true;
        auto other = std::ranges::begin(b);
        for (const auto& each : a) same &= forEachPair(each, *other++, f);
        return same;
    } else {
        f(double(a.x), double(b.x)), f(double(a.y), double(b.y)), f(double(a.z), double(b.z));
        return true;
    }
}

// Sums over all pairs of numbers.
struct Differences {
    Largest largest;                   // |x - y|
    double squares = 0, expected = 0;  // sums of squares of x - y, and of y
    std::size_t count = 0;
};
template <class A, class B>
Differences differencesOf(const A& a, const B& b) {
    Differences sums;
    const bool same_size = forEachPair(a, b, [&](double x, double y) {
        sums.largest.add(std::abs(x - y));
        sums.squares += (x - y) * (x - y);
        sums.expected += y * y;
        ++sums.count;
    });
    if (!same_size) sums.largest.add(std::numeric_limits<double>::infinity());
    EXPECT_TRUE(same_size) << "the sizes differ";
    if (!std::isfinite(sums.largest.value())) sums.squares = std::numeric_limits<double>::infinity();
    return sums;
}

// The largest |x - y|.
template <class A, class B>
double largestDifference(const A& a, const B& b) {
    return differencesOf(a, b).largest;
}
// The square root of the sum of (x - y)^2: of two vectors their distance.
template <class A, class B>
double distanceBetween(const A& a, const B& b) {
    return std::sqrt(differencesOf(a, b).squares);
}
// The square root of the mean of (x - y)^2.
template <class A, class B>
double rmsDifference(const A& a, const B& b) {
    const Differences sums = differencesOf(a, b);
    return std::sqrt(sums.squares / double(sums.count));
}
// |a - expected| / |expected|, which must not be zero.
template <class A, class B>
double relativeDifference(const A& a, const B& expected) {
    const Differences sums = differencesOf(a, expected);
    EXPECT_GT(sums.expected, 0) << "relative to nothing";
    return std::sqrt(sums.squares / sums.expected);
}
// The largest distance of two points of the same index.
template <class A, class B>
double largestDistance(const A& a, const B& b) {
    Largest largest;
    if (std::ranges::size(a) != std::ranges::size(b)) largest.add(std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < std::ranges::size(a) && i < std::ranges::size(b); ++i) {
        double squares = 0;
        forEachPair(a[i], b[i], [&](double x, double y) { squares += (x - y) * (x - y); });
        largest.add(std::sqrt(squares));
    }
    return largest;
}

// The largest number, and the largest absolute one.
template <class A>
double largestOf(const A& a) {
    Largest largest;
    forEachPair(a, a, [&](double x, double) { largest.add(x); });
    return largest;
}
template <class A>
double largestMagnitude(const A& a) {
    Largest largest;
    forEachPair(a, a, [&](double x, double) { largest.add(std::abs(x)); });
    return largest;
}

}  // namespace penumbra
