#include <gtest/gtest.h>

#include "fit/models/features.h"
#include "tests/difference.h"
#include "tests/fit/synthetic_character.h"

namespace penumbra::test_features {
namespace {

std::vector<double> featuresOf(const FeatureRecipe& recipe, int joint, const VisibilityFrame& frame) {
    std::vector<Mat3> rotations;
    for (const Affine& bone : frame.bones) rotations.push_back(nearestRotation(bone.linear()));
    std::vector<double> raw(recipe.count());
    rawFeatures(recipe, joint, frame.bones, rotations, frame.pose, raw);
    return raw;
}

FeatureRecipe chainRecipe(FeatureKind kind) {
    const Mesh mesh = synthetic::tube(24, 8);
    const Skin skin = synthetic::chainSkin(mesh);
    const double scale = boxDiagonal(mesh.rest_positions);
    const std::vector<Vec3> centers = jointCenters(mesh, skin);
    return {kind, scale, centers, jointSpreads(mesh, skin, centers, scale), 12};
}

TEST(RelativeBones, AreZeroInTheRestPose) {
    const FeatureRecipe recipe = chainRecipe(FeatureKind::kRelativeBones);
    VisibilityFrame frame;
    frame.bones.resize(4);
    for (double x : featuresOf(recipe, 1, frame)) EXPECT_NEAR(x, 0, 1e-6);
}

TEST(RelativeBones, DoNotChangeWhenTheWholeCharacterMoves) {
    const FeatureRecipe recipe = chainRecipe(FeatureKind::kRelativeBones);
    const Affine world = synthetic::affine(synthetic::rotationAbout({1, -2, 3}, 1.9f), {3, -1, 2});
    for (int joint = 0; joint < 4; ++joint) {
        VisibilityFrame still, moved;
        synthetic::swing(7, {}, still);
        synthetic::swing(7, world, moved);
        const std::vector<double> a = featuresOf(recipe, joint, still), b = featuresOf(recipe, joint, moved);
        ASSERT_EQ(a.size(), 36u);
        for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 3e-6) << "joint " << joint << " " << i;
    }
}

// Bone 1 is turned by 90 degrees about z and moved by (1, 2, 3). Its position and rotation are seen in the frame of
// bone 0, which is itself turned by 90 degrees about y: R_c^T takes (x, y, z) to (-z, y, x).
TEST(RelativeBones, HaveTheValuesOfTheRecipe) {
    FeatureRecipe recipe;
    recipe.scale = 2;
    recipe.joint_centers = {{0, 0, 0}, {1, 0, 0}};
    VisibilityFrame frame;
    const float right = float(std::numbers::pi / 2);
    frame.bones = {synthetic::affine(synthetic::rotationAbout({0, 1, 0}, right), {0, 0, 0}),
                   synthetic::affine(synthetic::rotationAbout({0, 0, 1}, right), {1, 2, 3})};
    const std::vector<double> raw = featuresOf(recipe, 0, frame);
    // M_1 (1,0,0) = (0,1,0) + (1,2,3) = (1,3,3). In bone 0 that is (-3,3,1). Then the center is taken off and the
    // result halved.
    const std::vector<double> expected = {-2, 1.5, 0.5, -1, 0, -1, 1, -1, 0, 0, -1, -1};
    ASSERT_EQ(raw.size(), expected.size());
    for (std::size_t i = 0; i < raw.size(); ++i) EXPECT_NEAR(raw[i], expected[i], 1e-6) << i;
}

TEST(RelativeBones, StayFiniteWithACollapsedBone) {
    const FeatureRecipe recipe = chainRecipe(FeatureKind::kRelativeBones);
    VisibilityFrame frame;
    synthetic::swing(7, {}, frame);
    frame.bones[1] = Affine{{}};
    // A frame without a size is that of its rotation, at the origin.
    const Mat3d to_cluster = transposed(toDouble(nearestRotation(frame.bones[1].linear())));
    std::vector<double> expected;
    for (const std::size_t j : {0u, 2u, 3u}) {
        const Affine& bone = frame.bones[j];
        const Vec3d center = toDouble(recipe.joint_centers[j]);
        const Vec3d seen = to_cluster * toDouble(bone.point(recipe.joint_centers[j]));
        const Vec3d moved = (seen - center) / recipe.scale;
        expected.insert(expected.end(), {moved.x, moved.y, moved.z});
        const Mat3d turned = to_cluster * toDouble(nearestRotation(bone.linear()));
        for (std::size_t i = 0; i < 9; ++i) expected.push_back(turned.m[i] - (i % 4 == 0 ? 1 : 0));
    }
    EXPECT_LT(largestDifference(featuresOf(recipe, 1, frame), expected), 1e-6);
    EXPECT_GT(largestMagnitude(expected), 0.1);
}

TEST(JointAngles, AreThePoseItself) {
    const FeatureRecipe recipe = chainRecipe(FeatureKind::kJointAngles);
    VisibilityFrame frame;
    synthetic::swing(3, {}, frame);
    const std::vector<double> raw = featuresOf(recipe, 2, frame);
    ASSERT_EQ(raw.size(), frame.pose.size());
    for (std::size_t i = 0; i < raw.size(); ++i) EXPECT_EQ(raw[i], frame.pose[i]);
}

// Joint 1 has moved to half a diagonal from the cluster, joint 2 stands at two diagonals. A place weighs 1 / (0.02 +
// d^2), a rotation 0.3 times that.
TEST(RelativeBones, WeighByTheirDistance) {
    FeatureRecipe recipe;
    recipe.scale = 2;
    recipe.joint_centers = {{0, 0, 0}, {2, 0, 0}, {0, 0, 4}};
    Matrix raw(1, recipe.count());
    raw(0, 0) = -0.5;
    const std::vector<std::size_t> rows{0};
    const ClusterPlace place{0, {0, 0, 0}};
    const std::array<double, 2> near{1 / 0.27, 1 / 4.02};
    const std::vector<double> features = featureWeights(recipe, place, raw, rows),
                              groups = groupWeights(recipe, place, raw, rows);
    ASSERT_EQ(features.size(), 24u);
    for (std::size_t i = 0; i < 24; ++i) EXPECT_NEAR(features[i], near[i / 12] * (i % 12 < 3 ? 1 : 0.3), 1e-12) << i;
    const double sum = near[0] * near[0] + near[1] * near[1];
    ASSERT_EQ(groups.size(), 3u);
    EXPECT_EQ(groups[0], 0);
    for (std::size_t j = 0; j < 2; ++j) EXPECT_NEAR(groups[j + 1], near[j] * near[j] / sum, 1e-12);
}

TEST(JointCenters, OfAJointThatMovesNothingIsItsAncestors) {
    Mesh mesh = synthetic::tube(24, 8);
    Skin skin = synthetic::chainSkin(mesh);
    skin.joint_names.push_back("end");
    skin.parents.push_back(3);
    const std::vector<Vec3> centers = jointCenters(mesh, skin);
    EXPECT_EQ(centers[4], centers[3]);
    EXPECT_NEAR(centers[0].y, 0.25, 0.03);
}

}  // namespace
}  // namespace penumbra::test_features
