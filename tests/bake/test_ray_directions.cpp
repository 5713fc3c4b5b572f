#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bake/trace/ray_directions.h"
#include "tests/difference.h"
#include "tests/sh/sh_project.h"

namespace penumbra::test_ray_directions {

TEST(RayDirections, AreTwiceTheRaysUnitAndPadded) {
    const RayDirections set = makeRayDirections(17, 3, 2);
    ASSERT_EQ(set.count, 34);
    ASSERT_EQ(set.packets.size(), 5u);
    int unit = 0, zero = 0;
    for (const DirectionPacket& p : set.packets)
        for (std::size_t k = 0; k < kLanes; ++k) {
            const double squared = double(p.x[k]) * p.x[k] + double(p.y[k]) * p.y[k] + double(p.z[k]) * p.z[k];
            unit += std::abs(squared - 1) < 1e-6;
            zero += squared == 0;
        }
    EXPECT_EQ(unit, 34);
    EXPECT_EQ(zero, 6);
}

TEST(RayDirections, SeedTurnsTheSetAndNothingElseDoes) {
    const auto first = [](std::uint64_t seed) { return makeRayDirections(64, seed, 1).packets[0].x; };
    EXPECT_EQ(first(1), first(1));
    EXPECT_NE(first(1), first(2));
}

// The means of 2048 turned Fibonacci directions and of their squares are 0 and 1/3 each. Measured 2e-7; bound 1e-5.
TEST(RayDirections, StayUniformWhenTurned) {
    const RayDirections set = makeRayDirections(1024, 7, 3);
    Vec3d mean, squares;
    for (const DirectionPacket& p : set.packets)
        for (std::size_t k = 0; k < kLanes; ++k) {
            const Vec3d d{p.x[k], p.y[k], p.z[k]};
            mean += d / 2048.0;
            squares += d * d / 2048.0;
        }
    EXPECT_NEAR(length(mean), 0, 1e-3);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(squares[c], 1.0 / 3, 1e-3);
}

TEST(RayDirections, PacketsAreNarrow) {
    // Eight neighbours of 2048 directions cover 8/2048 of the sphere, a cap of 0.125 radians. Morton order is not
    // perfect: the mean over packets of the widest angle to the first lane is 0.42 measured (random order: 2.4).
    const RayDirections set = makeRayDirections(1024, 1, 1);
    double sum = 0;
    for (const DirectionPacket& p : set.packets) {
        Largest widest;
        for (std::size_t k = 1; k < kLanes; ++k)
            widest.add(
                std::acos(std::min(1.0, double(p.x[0]) * p.x[k] + double(p.y[0]) * p.y[k] + double(p.z[0]) * p.z[k])));
        sum += widest;
    }
    EXPECT_LT(sum / double(set.packets.size()), 0.5);
}

// Compares the packet kernel of every order with the double-precision reference, on random subsets. Measured 4e-7
// relative to the largest coefficient.
TEST(AccumulateMoments, MatchesReferenceAtEveryOrder) {
    std::mt19937 random(5);
    for (int order = 1; order <= kMaxOrder; ++order) {
        const RayDirections set = makeRayDirections(509, 11, order);  // 1018 directions: the last packet is not full
        std::vector<LaneWeights> visible(set.packets.size());
        std::vector<Vec3d> directions;
        std::vector<std::uint8_t> flags;
        for (int s = 0; s < set.count; ++s) {
            const DirectionPacket& p = set.packets[std::size_t(s) / kLanes];
            const std::size_t k = std::size_t(s) % kLanes;
            directions.push_back({p.x[k], p.y[k], p.z[k]});
            flags.push_back(random() % 2);
            visible[std::size_t(s) / kLanes].lane[k] = flags.back();
        }
        std::vector<double> expected(std::size_t(coefficientCount(order)));
        projectVisibility(order, directions, flags, expected);
        std::vector<float> b(expected.size());
        accumulateMoments(set, visible, b);
        for (std::size_t i = 0; i < b.size(); ++i) EXPECT_NEAR(b[i], expected[i], 3e-6) << "order " << order;
    }
}

TEST(AboveHorizon, CountsEveryDirectionOnceOverOppositeNormals) {
    const RayDirections set = makeRayDirections(300, 1, 1);
    std::vector<LaneWeights> lanes(set.packets.size());
    const Vec3 normal = normalized(Vec3{0.3f, -0.4f, 0.8f});
    const std::size_t above = aboveHorizon(set, normal, Floor::kNone, lanes);
    EXPECT_EQ(above + aboveHorizon(set, -normal, Floor::kNone, lanes), 600u);
    EXPECT_NEAR(double(above), 300, 6);
    EXPECT_EQ(aboveHorizon(set, Vec3{}, Floor::kNone, lanes), 0u) << "a zero normal has no horizon";
}

TEST(AboveHorizon, GroundLeavesDirectionsThatPointUp) {
    const RayDirections set = makeRayDirections(300, 1, 1);
    std::vector<LaneWeights> lanes(set.packets.size());
    EXPECT_EQ(aboveHorizon(set, {0, -1, 0}, Floor::kSolid, lanes), 0u);
    EXPECT_EQ(aboveHorizon(set, {0, 1, 0}, Floor::kSolid, lanes), aboveHorizon(set, {0, 1, 0}, Floor::kNone, lanes));
    EXPECT_NEAR(double(aboveHorizon(set, {1, 0, 0}, Floor::kSolid, lanes)), 150, 6);
}

}  // namespace penumbra::test_ray_directions
