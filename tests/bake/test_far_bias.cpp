// A floor of a kilometre beside a character changes nothing of it.
#include <gtest/gtest.h>

#include "bake/trace/far_bias.h"
#include "bake/visibility/bake_visibility.h"
#include "bake/visibility/frame_scene.h"
#include "tests/formats/glb_writer.h"

namespace penumbra::test_far_bias {
namespace {

shapes::Shape squareFloor(float side, float y) {
    const float s = side / 2;
    return {{{-s, y, -s}, {-s, y, s}, {s, y, s}, {s, y, -s}}, {{0, 1, 2}, {0, 2, 3}}};
}

// Two balls of radius 0.3 that are 0.004 apart, and a floor far below them.
BakePlan planBalls(const char* name, float floor_side) {
    samples::GlbWriter file;
    shapes::Shape balls = shapes::sphere({}, 0.3, 16);
    shapes::append(balls, shapes::sphere({0.604, 0, 0}, 0.3, 16));
    file.node("balls", file.mesh(balls));
    if (floor_side > 0) file.node("floor", file.mesh(squareFloor(floor_side, -0.6f)));
    BakeOptions options;
    options.rays = 64;
    return planBake({file.save(name)}, options);
}

TEST(FarBias, AFloorChangesNoLengthOfTheCharacter) {
    const BakePlan alone = planBalls("balls_alone", 0), with = planBalls("balls_floor", 1000);
    EXPECT_EQ(with.rest_diagonal, alone.rest_diagonal);
    EXPECT_TRUE(alone.far_bias.empty());
    ASSERT_EQ(with.far_bias.size(), alone.header.mesh.vertexCount() + 4);
    EXPECT_EQ(with.far_bias.front(), with.bias);
    // The edges of the floor are 1000 m long, and 64 steps of a float there are 3.8 mm.
    EXPECT_NEAR(double(with.far_bias.back()) * with.rest_diagonal, 1000.0 / (1 << 18), 1e-5);
}

// The vertex that faces the other ball sees the same, and the floor sees its sky, but for the balls.
TEST(FarBias, RaysStartInTheGapAndOverTheFloor) {
    const auto shares = [](const char* name, float floor_side) {
        const BakePlan plan = planBalls(name, floor_side);
        BakeOptions options;
        options.rays = 64;
        const BakeDirections directions = makeBakeDirections(options);
        FrameScene posed = frameScene(plan, 0);
        const MomentTracer tracer = tracerOf(plan, posed, directions);
        const MomentOutput out = outputOf(posed.frame);
        traceMoments(tracer, posed.frame.positions, posed.frame.normals, out);
        std::vector<double> open;  // open share of the hemisphere
        for (std::size_t v = 0; v < posed.frame.positions.size(); ++v)
            open.push_back(double(out.coefficients[25 * v]) / unblockedOf(plan.header.quantity));
        std::size_t facing = 0;
        for (std::size_t v = 0; v < posed.frame.positions.size(); ++v)
            if (length(posed.frame.positions[v] - Vec3{0.3f, 0, 0}) < 1e-3f) facing = v;
        return std::pair(open[facing], open.back());
    };
    const double in_gap = shares("balls_alone", 0).first;
    const auto [beside_floor, floor] = shares("balls_floor", 1000);
    EXPECT_LT(in_gap, 0.25);
    EXPECT_NEAR(beside_floor, in_gap, 0.1);
    EXPECT_GT(floor, 0.95);
}

}  // namespace
}  // namespace penumbra::test_far_bias
