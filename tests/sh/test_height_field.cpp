#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "sh/height/field_in_scene.h"
#include "sh/height/height_brush.h"
#include "sh/height/height_field.h"
#include "tests/sh/height_samples.h"

namespace penumbra::test_height_field {
namespace {

std::vector<float> levelOf(const HeightField& field, std::size_t l) {
    const HeightLevel& level = field.levels()[l];
    const float* const from = field.allHeights() + level.first;
    return {from, from + level.rows * level.columns};
}

TEST(HeightField, HasTheLargestOfFourAtEveryPointOfALevel) {
    // 3 x 5, which is no power of two.
    const std::vector<float> heights = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 15, 14, 13, 12, 11};
    const HeightField field({3, 5}, heights);
    ASSERT_EQ(field.levels().size(), 4u);
    EXPECT_EQ(levelOf(field, 1), (std::vector<float>{7, 9, 10, 15, 13, 11}));
    EXPECT_EQ(levelOf(field, 2), (std::vector<float>{15, 11}));
    EXPECT_EQ(levelOf(field, 3), (std::vector<float>{15}));
}

TEST(HeightField, OfOnePointHasOneLevel) {
    const HeightField field({1, 1}, std::vector<float>{3});
    EXPECT_EQ(field.levels().size(), 1u);
    EXPECT_EQ(field.at(7, -2), 3);
    EXPECT_EQ(field.normal(0, 0).z, 1);
}

TEST(HeightField, SetOfABoxGivesTheLevelsOfTheWhole) {
    std::vector<float> heights = fractalHeights(37, 50, 2, 3);
    HeightField field({37, 50}, heights);
    const TexelBox box{10, 21, 19, 25};
    std::vector<float> bump;
    for (int r = box.first_row; r < box.end_row; ++r)
        for (int c = box.first_column; c < box.end_column; ++c)
            bump.push_back(heights[std::size_t(r * 50 + c)] += float(r % 3) - 1);
    field.set(box, bump);
    const HeightField whole({37, 50}, heights);
    for (std::size_t l = 0; l < whole.levels().size(); ++l) EXPECT_EQ(levelOf(field, l), levelOf(whole, l)) << l;
}

TEST(HeightField, SetTellsWhatChangedAndNothingElse) {
    std::vector<float> heights(64 * 64, 0.0f);
    heights[5 * 64 + 5] = 10;
    HeightField field({64, 64}, heights);
    const std::vector<float> low = {1};
    const std::span<const TexelBox> changed = field.set({6, 6, 7, 7}, low);
    EXPECT_EQ(changed[0], (TexelBox{6, 6, 7, 7}));
    EXPECT_EQ(changed[1], (TexelBox{3, 3, 4, 4}));
    for (std::size_t l = 2; l < changed.size(); ++l) EXPECT_TRUE(changed[l].empty()) << l;  // below the peak beside it
    EXPECT_TRUE(field.set({6, 6, 7, 7}, low)[0].empty());
}

TEST(HeightField, IsBilinearAndGoesOnAsItsBorderSays) {
    const std::vector<float> heights = {0, 1, 2, 10, 11, 12};
    for (const HeightBorder border : {HeightBorder::kClamped, HeightBorder::kPeriodic}) {
        const HeightField field({2, 3, 1, 1, border}, heights);
        EXPECT_FLOAT_EQ(field.at(0.5f, 0.25f), 5.25f);
        EXPECT_EQ(field.at(0, 2), 2);
    }
    const HeightField clamped({2, 3}, heights), periodic({2, 3, 1, 1, HeightBorder::kPeriodic}, heights);
    EXPECT_EQ(clamped.at(-5, 9), 2);
    EXPECT_FLOAT_EQ(periodic.at(0, 2.5f), 1);  // between 2 and 0
    EXPECT_EQ(periodic.at(-1, -3), 10);
}

// One square with the heights 0, 2, 4 and 10: bilinear its middle is 4, and on the line from (1, 0) to (0, 1) it is 3.
TEST(HeightField, OnTrianglesIsLinearOnBothSidesOfTheDiagonal) {
    const HeightField square({2, 2}, std::vector<float>{0, 2, 4, 10});
    EXPECT_FLOAT_EQ(square.at(0.5f, 0.5f), 4);
    EXPECT_DOUBLE_EQ(square.onTriangles(0.5, 0.5), 3);
    EXPECT_DOUBLE_EQ(square.onTriangles(0.25, 0.5), 0.25 * 4 + 0.5 * 2);
    EXPECT_DOUBLE_EQ(square.onTriangles(0.75, 0.5), 10 - 0.25 * (10 - 2) - 0.5 * (10 - 4));
    const std::vector<float> heights = {0, 1, 2, 10, 11, 12};
    const HeightField clamped({2, 3}, heights), periodic({2, 3, 1, 1, HeightBorder::kPeriodic}, heights);
    for (const HeightField* field : {&clamped, &periodic})
        for (int r = 0; r < 2; ++r)
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(field->onTriangles(r, c), double(heights[std::size_t(3 * r + c)])) << r << " " << c;
    EXPECT_EQ(clamped.onTriangles(-5, 9), 2);
    EXPECT_EQ(clamped.onTriangles(std::numeric_limits<double>::quiet_NaN(), 1), 1);
    EXPECT_DOUBLE_EQ(periodic.onTriangles(0, 2.5), 1);  // between 2 and 0
    EXPECT_EQ(periodic.onTriangles(-1, -3), 10);
    EXPECT_DOUBLE_EQ(periodic.onTriangles(1.5, 2.75), periodic.onTriangles(-0.5, -0.25));
}

Affine turnedAndPlaced(double yaw, Vec3 place) {
    const auto c = float(std::cos(yaw)), s = float(std::sin(yaw));
    return {{c, 0, s, place.x, 0, 1, 0, place.y, -s, 0, c, place.z}};
}

// Columns of two feet, 0.1 m wide, and a head 2 m above them.
std::vector<Vec3> feetAndHead(Vec3 left, Vec3 right) {
    std::vector<Vec3> pose;
    for (const Vec3 foot : {left, right})
        for (const float x : {-0.05f, 0.05f})
            for (const float z : {-0.05f, 0.05f}) pose.push_back(foot + Vec3{x, 0, z});
    pose.push_back({0, 2, 0});
    return pose;
}

// A plane that rises by 0.3 along x and by -0.2 along z, and 5 where both are 0.
HeightField slope() {
    std::vector<float> heights;
    for (int r = 0; r < 41; ++r)
        for (int c = 0; c < 61; ++c)
            heights.push_back(5 + 0.3f * (0.25f * float(c) - 7) - 0.2f * (0.5f * float(r) - 9));
    return HeightField({41, 61, 0.5f, 0.25f}, heights);
}
const Vec3d kSlopeCorner{-7, 0, -9};

TEST(GroundUnderPose, IsThatBelowTheFeetWhereverTheyAre) {
    const HeightField field = slope();
    const auto plane = [](double x, double z) { return 5 + 0.3 * x - 0.2 * z; };
    EXPECT_NEAR(groundUnderPose(field, kSlopeCorner, {}, turnedAndPlaced(0, {1, 9, 2})), plane(1, 2), 1e-5);
    // Both feet stand: the ground below the middle between them, however far the clip has walked.
    for (const float walked : {0.0f, 2.5f}) {
        const std::vector<Vec3> pose = feetAndHead({-0.1f, 0.02f, walked}, {0.1f, 0.02f, walked + 0.6f});
        EXPECT_NEAR(groundUnderPose(field, kSlopeCorner, pose, turnedAndPlaced(0, {1, 9, 2})),
                    plane(1, 2.3 + double(walked)), 1e-5);
        // A quarter turn takes z to x.
        const Affine turned = turnedAndPlaced(std::numbers::pi / 2, {1, 0, 2});
        EXPECT_NEAR(groundUnderPose(field, kSlopeCorner, pose, turned), plane(1.3 + double(walked), 2), 1e-5);
    }
    const std::vector<Vec3> point = {{0.5f, 3, 0.25f}};
    EXPECT_NEAR(groundUnderPose(field, kSlopeCorner, point, turnedAndPlaced(0, {})), plane(0.5, 0.25), 1e-5);
}

// The lifted foot counts by the square of what is left of the reach, so that nothing jumps while it swings past the
// other one. A foot above the reach counts nothing.
TEST(GroundUnderPose, GoesFromTheFootThatLeavesToTheOneThatLands) {
    const HeightField field = slope();
    const auto ground = [&](float left, float right) {
        const std::vector<Vec3> pose = feetAndHead({-0.1f, left, 0}, {0.1f, right, 0.6f});
        return groundUnderPose(field, kSlopeCorner, pose, turnedAndPlaced(0, {}));
    };
    const double reach = double(kStandingShare) * std::sqrt(0.3 * 0.3 + 4 + 0.7 * 0.7);
    EXPECT_NEAR(ground(0, 0.9f), 5 - 0.03, 1e-5);
    EXPECT_NEAR(ground(0.9f, 0), 5 + 0.03 - 0.12, 1e-5);
    const double weight = std::pow(1 - 0.2 / reach, 2);
    EXPECT_NEAR(ground(0, 0.2f), 5 - 0.03 + (0.06 - 0.12) * weight / (1 + weight), 1e-5);
    double before = ground(0, 0.9f);
    for (int i = 1; i <= 200; ++i) {  // measured: 0.0006 a step of 9 mm
        const double now =
            ground(0.9f * std::max(0.0f, float(i - 100)) / 100, 0.9f * float(std::max(0, 100 - i)) / 100);
        EXPECT_LT(std::abs(now - before), 0.0012) << i;
        before = now;
    }
    EXPECT_NEAR(before, 5 + 0.03 - 0.12, 1e-5);
}

TEST(HeightField, NormalsOfAPlaneAreItsOwnUpToTheEdge) {
    // z = 2 x - y with cells of 0.5 and 0.25.
    std::vector<float> heights;
    for (int r = 0; r < 5; ++r)
        for (int c = 0; c < 4; ++c) heights.push_back(2 * 0.5f * float(r) - 0.25f * float(c));
    const HeightField field({5, 4, 0.5f, 0.25f}, heights);
    for (int r = 0; r < 5; ++r)
        for (int c = 0; c < 4; ++c) {
            const Vec3 n = field.normal(r, c), expected = normalized(Vec3{-2, 1, 1});
            EXPECT_NEAR(length(n - expected), 0, 1e-6) << r << " " << c;
        }
}

TEST(HeightStroke, RaisesABumpThatEndsAtItsRadius) {
    const HeightField field({20, 30, 0.5f, 0.25f}, std::vector<float>(600, 3));
    std::vector<float> heights;
    const TexelBox box = strokeHeights(field, {10, 12, 1, 2}, heights);
    EXPECT_EQ(box, (TexelBox{8, 8, 13, 17}));
    ASSERT_EQ(heights.size(), 5u * 9u);
    const auto at = [&](int r, int c) { return heights[std::size_t((r - 8) * 9 + c - 8)]; };
    EXPECT_FLOAT_EQ(at(10, 12), 5);
    EXPECT_FLOAT_EQ(at(11, 12), 3 + 2 * 0.75f * 0.75f);  // half a metre away, and so is the next
    EXPECT_FLOAT_EQ(at(10, 14), 3 + 2 * 0.75f * 0.75f);
    EXPECT_FLOAT_EQ(at(12, 12), 3);
    EXPECT_FLOAT_EQ(at(8, 8), 3);  // beyond the radius
    // It ends at the edges, and heights at their limit.
    EXPECT_EQ(strokeHeights(field, {-1, 29, 1, -1}, heights), (TexelBox{0, 25, 2, 30}));
    strokeHeights(field, {10, 12, 1, 3e7f}, heights);
    EXPECT_FLOAT_EQ(at(10, 12), kMaxElevation);
    // Beside the field, without a radius, between points, and of no number.
    const float nan = std::nanf("");
    for (const HeightStroke& none : {HeightStroke{100, 12, 1, 1},
                                     {10, 12, 0, 1},
                                     {10, 12, -1, 1},
                                     {10.5f, 12.5f, 0.01f, 1},
                                     {nan, 12, 1, 1},
                                     {10, 12, nan, 1},
                                     {10, 12, 1, nan}}) {
        EXPECT_TRUE(strokeHeights(field, none, heights).empty());
        EXPECT_TRUE(heights.empty());
    }
    EXPECT_EQ(strokeHeights(field, {10, 12, 1e9f, 1}, heights), (TexelBox{0, 0, 20, 30}));
}

TEST(HeightGrid, NamesTheFieldThatIsOutOfRange) {
    EXPECT_EQ(findProblem({65536, 1}), "");
    EXPECT_NE(findProblem({1, 65537}).find("columns is 65537"), std::string::npos);
    EXPECT_NE(findProblem({0, 1}).find("rows is 0"), std::string::npos);
    EXPECT_NE(findProblem({65536, 65536}).find("rows times columns"), std::string::npos);
    EXPECT_NE(findProblem({2, 2, 0}).find("cell (rows)"), std::string::npos);
    EXPECT_NE(findProblem({2, 2, 1, std::nanf("")}).find("cell (columns)"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test_height_field
