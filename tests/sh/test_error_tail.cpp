#include <gtest/gtest.h>

#include <cmath>

#include "sh/error_tail.h"

namespace penumbra::test_error_tail {
namespace {

constexpr double kStep = 1.0 / double(ErrorTail::kBins);

// For the errors i / n, i = 1 .. n, the share q does not exceed q.
TEST(ErrorTail, QuantileOfEvenErrorsIsTheShare) {
    ErrorTail tail;
    for (int i = 1; i <= 10000; ++i) tail.add(i / 10000.0);
    EXPECT_EQ(tail.largest(), 1);
    for (const double share : {0.001, 0.5, 0.999}) {
        EXPECT_GE(tail.quantile(share), share - 1e-12);
        EXPECT_LE(tail.quantile(share), share + kStep);
    }
    EXPECT_EQ(tail.quantile(1), 1);
}

TEST(ErrorTail, OneOfAThousandIsLeftOut) {
    ErrorTail tail;
    for (int i = 0; i < 999; ++i) tail.add(0);
    tail.add(0.64);
    EXPECT_EQ(tail.quantile(0.999), 0);
    EXPECT_EQ(tail.largest(), 0.64);
    tail.add(0.32);  // two of 1001
    EXPECT_NEAR(tail.quantile(0.999), 0.32, kStep);
}

TEST(ErrorTail, NeverExceedsTheLargest) {
    ErrorTail tail;
    tail.add(0.3 * kStep);
    EXPECT_EQ(tail.quantile(0.999), 0.3 * kStep);
    tail.add(7);  // E is not above 1, but nothing keeps errors from it
    EXPECT_EQ(tail.quantile(0.999), 7);
    EXPECT_EQ(tail.quantile(0.5), kStep);
}

TEST(ErrorTail, SumOfTwoIsThatOfAll) {
    ErrorTail all, even, odd;
    for (int i = 0; i < 5000; ++i) {
        const double error = std::pow(std::abs(std::sin(double(i))), 3);
        all.add(error);
        (i % 2 ? odd : even).add(error);
    }
    even.add(odd);
    EXPECT_EQ(even.largest(), all.largest());
    for (const double share : {0.1, 0.5, 0.9, 0.999}) EXPECT_EQ(even.quantile(share), all.quantile(share));
}

TEST(ErrorTail, NanShows) {
    ErrorTail tail, other;
    EXPECT_TRUE(std::isnan(tail.quantile(0.999))) << "of nothing";
    tail.add(std::nan(""));
    tail.add(0.5);
    EXPECT_TRUE(std::isnan(tail.quantile(0.5)));
    other.add(0.5);
    other.add(tail);
    EXPECT_TRUE(std::isnan(other.largest()));
    EXPECT_TRUE(std::isnan(other.quantile(0.999)));
}

}  // namespace
}  // namespace penumbra::test_error_tail
