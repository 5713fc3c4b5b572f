// The differences that all other tests rely on.
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "sh/vec3.h"
#include "tests/difference.h"

namespace penumbra::test_difference {
namespace {

using Floats = std::vector<float>;

TEST(Difference, OfNumbersVectorsAndRangesOfThem) {
    EXPECT_EQ(largestDifference(3.0f, 5), 2);
    EXPECT_EQ(largestDifference(Vec3{1, 2, 3}, Vec3d{1, 5, 1}), 3);
    EXPECT_EQ(largestDifference(Floats{1, -2}, std::array<double, 2>{1, 2}), 4);
    EXPECT_EQ(largestDifference(std::vector<Vec3>{{1, 2, 3}, {}}, std::vector<Vec3>{{1, 2, 3}, {0, 0, -7}}), 7);
    EXPECT_EQ(largestDifference(std::vector<Floats>{{1}, {2, 3}}, std::vector<Floats>{{1}, {2, 4}}), 1);
    EXPECT_EQ(distanceBetween(Floats{0, 0}, Floats{3, 4}), 5);
    EXPECT_EQ(rmsDifference(Floats{0, 0, 0, 0}, Floats{1, 1, 1, 5}), std::sqrt(7.0));
    EXPECT_EQ(relativeDifference(Floats{3, 0}, Floats{0, 4}), 1.25);
    EXPECT_EQ(largestDistance(std::vector<Vec3>{{}, {1, 1, 1}}, std::vector<Vec3>{{0, 3, 4}, {1, 1, 1}}), 5);
    EXPECT_EQ(largestOf(Floats{-3, -1}), -1);
    EXPECT_EQ(largestMagnitude(Floats{-3, -1}), 3);
}

// Whether `f` fails the test that calls it, with a result that is within no bound.
template <class F>
bool fails(const F& f) {
    testing::TestPartResultArray failures;
    double result = 0;
    {
        const testing::ScopedFakeTestPartResultReporter reporter(
            testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &failures);
        result = f();
    }
    return failures.size() > 0 && !std::isfinite(result);
}

// Whether every function fails on the pair.
template <class A, class B>
bool allFail(const A& a, const B& b) {
    return fails([&] { return largestDifference(a, b); }) && fails([&] { return distanceBetween(a, b); }) &&
           fails([&] { return rmsDifference(a, b); }) && fails([&] { return relativeDifference(a, b); });
}

TEST(Difference, OfWhatIsNotFiniteFails) {
    const Floats good = {1, 1, 2};
    for (const float value : {NAN, INFINITY, -INFINITY})
        for (const std::size_t at : {0u, 1u, 2u}) {
            Floats bad = good;
            bad[at] = value;
            EXPECT_TRUE(allFail(bad, good) && allFail(good, bad) && allFail(bad, bad)) << value << " " << at;
            const std::vector<Vec3> points = {{}, {bad[0], bad[1], bad[2]}, {}}, others(3);
            EXPECT_TRUE(allFail(points, others)) << value << " " << at;
            EXPECT_TRUE(fails([&] { return largestDistance(points, others); })) << value << " " << at;
            EXPECT_TRUE(fails([&] { return largestOf(bad); })) << value << " " << at;
            EXPECT_TRUE(fails([&] { return largestMagnitude(points); })) << value << " " << at;
        }
}

TEST(Difference, OfOtherSizesAndOfNothingFails) {
    const Floats one = {1}, two = {1, 1}, none;
    for (const auto& [a, b] : {std::pair(one, two), {two, one}, {none, one}, {one, none}, {none, none}})
        EXPECT_TRUE(allFail(a, b)) << a.size() << " " << b.size();
    EXPECT_TRUE(allFail(std::vector{one, one}, std::vector{one, two}));
    const std::vector<Vec3> points(2);
    EXPECT_TRUE(fails([&] { return largestDistance(points, std::vector<Vec3>(1)); }));
    EXPECT_TRUE(fails([&] { return largestDistance(std::vector<Vec3>(), std::vector<Vec3>()); }));
    EXPECT_TRUE(fails([&] { return largestOf(none); }));
    EXPECT_TRUE(fails([&] { return largestMagnitude(none); }));
    EXPECT_TRUE(fails([&] { return relativeDifference(one, Floats{0}); }));
}

TEST(Difference, LargestFailsWhereItIsRead) {
    Largest largest;
    EXPECT_TRUE(fails([&] { return largest.value(); })) << "nothing was added";
    largest.add(-2);
    largest.add(-3);
    EXPECT_EQ(largest, -2);
    largest.add(NAN);
    EXPECT_TRUE(fails([&] { return largest.value(); }));
    largest.add(1);
    EXPECT_TRUE(fails([&] { return largest.value(); })) << "NaN stays";
}

}  // namespace
}  // namespace penumbra::test_difference
