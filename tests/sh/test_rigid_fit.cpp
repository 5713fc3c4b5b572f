#include <gtest/gtest.h>

#include <vector>

#include "sh/quaternion.h"
#include "sh/rigid_fit.h"
#include "tests/difference.h"

namespace penumbra::test_rigid_fit {
namespace {

std::vector<Vec3> points(std::size_t count, Vec3 place, bool flat) {
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < count; ++i)
        out.push_back(place + Vec3{std::sin(1.3f * float(i)), std::cos(0.7f * float(i)),
                                   flat ? 0 : std::sin(2.1f * float(i) + 1)});
    return out;
}

Affine motion(Vec3d rotation_vector, Vec3 translation) {
    const Mat3d r = matrixOf(rotationOf(rotation_vector));
    Affine out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.m[std::size_t(4 * i + j)] = float(r(i, j));
    out.m[3] = translation.x, out.m[7] = translation.y, out.m[11] = translation.z;
    return out;
}

std::vector<Affine> fit(const std::vector<Vec3>& rest, const std::vector<std::uint16_t>& part,
                        const std::vector<Vec3>& positions, std::size_t parts) {
    std::vector<PartSums> sums(parts);
    std::vector<Affine> bones(parts);
    partMotions(rest, part, positions, sums, bones);
    return bones;
}

// The parts may be flat. The points of a flat part alone do not tell a rotation from a reflection. The largest error
// was 3e-6 at this distance from the origin (the translation), and 4e-5 where the rotation is near pi and the prior
// pulls most.
TEST(PartMotions, FindsTheMotionOfRigidParts) {
    for (bool flat : {false, true})
        for (double angle : {0.0, 0.4, 1.5, 3.0}) {
            const Affine first = motion({angle * 0.6, 0, angle * 0.8}, {3, -1, 2}),
                         second = motion({0, -angle, 0}, {0.5f, 0, -4});
            std::vector<Vec3> rest = points(40, {1, 2, 3}, flat), positions;
            const std::vector<Vec3> other = points(25, {-2, 0, 1}, flat);
            rest.insert(rest.end(), other.begin(), other.end());
            std::vector<std::uint16_t> part;
            for (std::size_t v = 0; v < rest.size(); ++v) {
                part.push_back(v < 40 ? 2 : 0);
                positions.push_back((v < 40 ? first : second).point(rest[v]));
            }
            const std::vector<Affine> bones = fit(rest, part, positions, 3);
            EXPECT_LT(largestDifference(bones[2].m, first.m), 2e-4) << "flat " << flat << " angle " << angle;
            EXPECT_LT(largestDifference(bones[0].m, second.m), 2e-4) << "flat " << flat << " angle " << angle;
            EXPECT_EQ(bones[1], Affine{});  // nothing there
        }
}

TEST(PartMotions, NeverReflects) {
    const std::vector<Vec3> rest = points(30, {}, false);
    std::vector<Vec3> mirrored;
    for (Vec3 p : rest) mirrored.push_back({-p.x, p.y, p.z});
    const Mat3 r = fit(rest, std::vector<std::uint16_t>(30), mirrored, 1)[0].linear();
    EXPECT_NEAR(
        dot(cross(Vec3{r(0, 0), r(1, 0), r(2, 0)}, Vec3{r(0, 1), r(1, 1), r(2, 1)}), Vec3{r(0, 2), r(1, 2), r(2, 2)}),
        1, 1e-6);
}

TEST(PartMotions, WhatPointsLeaveOpenDoesNotTurn) {
    const Affine one = fit({{1, 2, 3}}, {0}, {{4, 4, 4}}, 1)[0];
    EXPECT_EQ(one, motion({}, {3, 2, 1}));
    // A line turns by 90 degrees about z. Nothing says how it turns about itself.
    const Affine line = fit({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {0, 0, 0}, {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}}, 1)[0];
    EXPECT_LT(largestDifference(line.m, motion({0, 0, 1.5707963}, {}).m), 1e-4);
}

// The scale of the scene changes nothing, down to where squares of floats would vanish. The prior turns back by 2e-5.
TEST(PartMotions, TinyAndHugeScenesTurnAlike) {
    const std::vector<Vec3> rest = points(20, {}, true);
    const Affine turn = motion({0.3, 0.5, -0.2}, {});
    for (float scale : {1e-22f, 1.0f, 1e15f}) {
        std::vector<Vec3> small, moved;
        for (Vec3 p : rest) small.push_back(p * scale), moved.push_back(turn.point(p) * scale);
        const Mat3 r = fit(small, std::vector<std::uint16_t>(20), moved, 1)[0].linear();
        for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(r.m[i], turn.linear().m[i], 5e-5) << scale;
    }
}

TEST(InputBones, AreTranslations) {
    EXPECT_EQ(pointBone({1, 2, 3}, {0.5f, 2, 5}), motion({}, {0.5f, 0, -2}));
    EXPECT_EQ(numberBone(7, 5, 0.25f), motion({}, {0.5f, 0, 0}));
}

}  // namespace
}  // namespace penumbra::test_rigid_fit
