// Tests poses between sampled frames on a chain of joints whose true motion is known.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "player/view/playback/playhead.h"
#include "player/view/playback/pose_interpolation.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"

namespace penumbra::test_pose_interpolation {
namespace {

constexpr std::size_t kJoints = 4, kFrames = 24;
// The joints' rest places: hips, the spine above, an elbow, and a prop that is bound to the elbow and does not move
// itself.
constexpr std::array<Vec3d, kJoints> kRest = {{{0, 1, 0}, {0, 1.4, 0}, {0.5, 1.5, 0.1}, {0.9, 1.5, 0.1}}};

struct Place {
    Mat3d turn;
    Vec3d at;
};

Place after(const Place& a, const Place& b) { return {a.turn * b.turn, a.turn * b.at + a.at}; }

// Turns the joint about its rest place, from its parent's rest frame.
Place turned(std::size_t joint, const Quaternion& q) {
    const Mat3d r = matrixOf(q);
    return {r, kRest[joint] - r * kRest[joint]};
}

// Returns the turns of spine (a ball joint) and elbow (a hinge) in a frame.
Quaternion turnOf(std::size_t joint, std::size_t frame) {
    const double t = double(frame);
    if (joint == 1) return rotationOf(Vec3d{0.5 * std::sin(t), 0.7 * std::cos(1.7 * t), 0.4 * std::sin(2.3 * t)});
    if (joint == 2) return rotationOf(Vec3d{0, 0, 0.8 + 0.7 * std::sin(1.3 * t)});
    return {0, 0, 0, 1};
}

// Returns the places of hips that turn and walk, then of their children, `part` of the way to the next frame, joint
// by joint.
std::array<Place, kJoints> truePose(std::size_t frame, double part) {
    const auto hips = [](double t) { return rotationOf(Vec3d{0, 0.3 * t, 0}); };
    const auto way = [](double t) { return Vec3d{0.4 * t, 0.05 * std::sin(t), 0}; };
    std::array<Place, kJoints> pose;
    const double t = double(frame);
    pose[0] = turned(0, slerp(hips(t), hips(t + 1), part));
    pose[0].at += (1 - part) * way(t) + part * way(t + 1);
    for (std::size_t j = 1; j < kJoints; ++j)
        pose[j] = after(pose[j - 1], turned(j, slerp(turnOf(j, frame), turnOf(j, frame + 1), part)));
    return pose;
}

Affine affineOf(const Place& place) {
    Affine out;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) out.m[4 * r + c] = float(place.turn.m[3 * r + c]);
        out.m[4 * r + 3] = float(place.at[int(r)]);
    }
    return out;
}

struct Chain {
    std::vector<Vec3> positions, centers;
    std::vector<std::uint16_t> skin_joints;
    std::vector<float> skin_weights, pose;
    std::array<std::int32_t, kJoints> parents = {-1, 0, 1, 2};
    std::vector<Affine> bones;
    std::vector<double> times;
    AssetView asset;

    Chain() {
        for (std::size_t j = 0; j < kJoints; ++j) {  // each joint moves a vertex that is not at its pivot
            positions.push_back(toFloat(kRest[j] + Vec3d{0.1, 0.2, 0.05}));
            skin_joints.push_back(std::uint16_t(j));
            skin_weights.push_back(1);
        }
        centers = positions;
        for (std::size_t f = 0; f < kFrames; ++f) {
            times.push_back(double(f) / 3);
            for (const Place& place : truePose(f, 0)) bones.push_back(affineOf(place));
            for (std::size_t j = 0; j < kJoints; ++j) {
                const Vec3 v = toFloat(rotationVector(turnOf(j, f)));
                pose.insert(pose.end(), {v.x, v.y, v.z});
            }
        }
        use();
    }
    void use() {
        asset.mesh.positions = positions;
        asset.mesh.influences = 1;
        asset.mesh.skin_joints = skin_joints;
        asset.mesh.skin_weights = skin_weights;
        asset.model.joint_centers = centers;
        asset.animation.joint_names = {"hips", "spine", "elbow", "prop"};
        asset.animation.parents = parents;
        asset.animation.clips = {{"all", 0, kFrames}};
        asset.animation.times = times;
        asset.animation.bones = bones;
        asset.animation.pose_size = 3 * kJoints;
        asset.animation.pose = pose;
    }
};

TEST(PoseInterpolation, SampledFramesAreExact) {
    const Chain chain;
    PoseInterpolation between(chain.asset);
    for (const std::size_t frame : {0u, 7u, 22u})
        for (const double part : {0.0, 1.0}) {
            between.evaluate(frame, frame + 1, part);
            const std::size_t expected = frame + (part == 0 ? 0 : 1);
            EXPECT_TRUE(std::ranges::equal(between.bones(), chain.asset.animation.bonesOf(expected)));
            EXPECT_TRUE(std::ranges::equal(between.pose(), chain.asset.animation.poseOf(expected)));
        }
}

TEST(PoseInterpolation, GoesToSampledFramesWithoutAStep) {
    const Chain chain;
    PoseInterpolation between(chain.asset);
    for (const double part : {1e-7, 1 - 1e-7}) {
        between.evaluate(5, 6, part);
        const std::size_t frame = part < 0.5 ? 5 : 6;
        for (std::size_t j = 0; j < kJoints; ++j)
            for (std::size_t i = 0; i < 12; ++i)
                EXPECT_NEAR(between.bones()[j].m[i], chain.asset.animation.bonesOf(frame)[j].m[i], 2e-6f);
        for (std::size_t i = 0; i < between.pose().size(); ++i)
            EXPECT_NEAR(between.pose()[i], chain.asset.animation.poseOf(frame)[i], 1e-6f);
    }
}

// A ball joint's pivot is where it is bound, and a hinge's is on its axis. The weight of the center moves them by
// 1e-4 / (the mean square of what the turn changes): 0.4 mm of 0.23 m measured.
TEST(PoseInterpolation, FindsWhereJointsTurn) {
    const Chain chain;
    const PoseInterpolation between(chain.asset);
    EXPECT_LT(length(between.pivot(1) - kRest[1]), 1e-3);
    const Vec3d off = between.pivot(2) - kRest[2];
    EXPECT_LT(std::hypot(off.x, off.y), 1e-3);
    EXPECT_NEAR(between.pivot(2).z, double(chain.positions[2].z), 1e-3) << "on the axis, nearest to what it moves";
}

// Between frames every joint turns about its pivot by a share of its turn, which is the motion that the frames were
// sampled from. Measured: 6e-5 m of a character of 2 m, from the pivots' 0.4 mm.
TEST(PoseInterpolation, IsTheMotionOfTheJoints) {
    const Chain chain;
    PoseInterpolation between(chain.asset);
    Largest worst;
    for (std::size_t f = 0; f + 1 < kFrames; ++f)
        for (const double part : {0.25, 0.5, 0.9}) {
            between.evaluate(f, f + 1, part);
            // The hips turn about the center of what they move here, not about their joint; only what hangs on them
            // matters.
            const std::array<Place, kJoints> truth = truePose(f, part);
            const auto seen = [&](std::size_t j, Vec3d p) {
                const Mat3d back = transposed(toDouble(between.bones()[0].linear()));
                return back *
                       (toDouble(between.bones()[j].point(toFloat(p))) - toDouble(between.bones()[0].translation()));
            };
            for (std::size_t j = 1; j < kJoints; ++j) {
                const Vec3d p = toDouble(chain.positions[j]);
                const Vec3d expected = transposed(truth[0].turn) * (truth[j].turn * p + truth[j].at - truth[0].at);
                worst.add(length(seen(j, p) - expected));
            }
        }
    EXPECT_LT(worst, 2e-4);
}

TEST(PoseInterpolation, BonesStayRigidAndJointsTogether) {
    const Chain chain;
    PoseInterpolation between(chain.asset);
    Largest stretch, gap;
    for (std::size_t f = 0; f + 1 < kFrames; ++f)
        for (int step = 1; step < 10; ++step) {
            between.evaluate(f, f + 1, step / 10.0);
            for (std::size_t j = 0; j < kJoints; ++j) {
                const Mat3d r = toDouble(between.bones()[j].linear()), square = transposed(r) * r;
                for (std::size_t i = 0; i < 9; ++i) stretch.add(std::abs(square.m[i] - (i % 4 == 0)));
                if (j == 0) continue;
                const Vec3 joint = toFloat(kRest[j]);
                gap.add(length(between.bones()[j].point(joint) - between.bones()[j - 1].point(joint)));
            }
        }
    EXPECT_LT(stretch, 5e-6);  // single precision
    EXPECT_LT(gap, 3e-4);      // metres; 1e-4 measured, of the pivots' 0.4 mm
}

// A character that grows from one frame to the next grows evenly in between.
TEST(PoseInterpolation, SizesChangeEvenly) {
    Chain chain;
    for (std::size_t b = 0; b < 2 * kJoints; ++b) {
        const float size = b < kJoints ? 1 : 3;
        chain.bones[b] = {{size, 0, 0, 0, 0, size, 0, 0, 0, 0, size, 0}};
    }
    PoseInterpolation between(chain.asset);
    between.evaluate(0, 1, 0.25);
    for (const Affine& bone : between.bones())
        for (std::size_t e = 0; e < 9; ++e) EXPECT_NEAR(bone.linear().m[e], e % 4 == 0 ? 1.5 : 0, 1e-5);
}

// A rotation vector of nearly pi and one of nearly -pi are neighbours: between them lies pi, not 0.
TEST(PoseInterpolation, RotationVectorsTakeTheShortWay) {
    Chain chain;
    for (const auto& [frame, angle] : {std::pair(0, 3.0f), {1, -3.0f}}) chain.pose[std::size_t(frame) * 12] = angle;
    for (const std::size_t i : {1u, 2u, 13u, 14u}) chain.pose[i] = 0;
    PoseInterpolation between(chain.asset);
    between.evaluate(0, 1, 0.25);
    EXPECT_NEAR(std::abs(between.pose()[0]), 3 + (2 * 3.14159265 - 6) / 4, 1e-5);
}

// A joint below one that is scaled to nothing moves by itself, and nothing becomes infinite.
TEST(PoseInterpolation, JointsOfNoSizeAreNoParents) {
    Chain chain;
    for (std::size_t e = 0; e < 12; ++e) chain.bones[3 * kJoints + 1].m[e] = 0;
    PoseInterpolation between(chain.asset);
    EXPECT_EQ(between.parent(2), -1);
    EXPECT_EQ(between.parent(3), 2);
    between.evaluate(2, 3, 0.5);
    for (std::size_t j = 0; j < kJoints; ++j) {  // the others keep their size
        const float size = j == 1 ? 0.5f : 1;
        const Mat3 linear = between.bones()[j].linear();
        for (int row = 0; row < 3; ++row)
            EXPECT_NEAR(length(Vec3{linear(row, 0), linear(row, 1), linear(row, 2)}), size, 1e-5) << j;
        EXPECT_LT(largestMagnitude(between.bones()[j].m), 3) << j;
    }
}

TEST(PoseInterpolation, AllocatesNothing) {
    const Chain chain;
    PoseInterpolation between(chain.asset);
    const std::size_t before = allocationCount();
    for (std::size_t f = 0; f + 1 < kFrames; ++f) between.evaluate(f, f + 1, 0.3);
    EXPECT_EQ(allocationCount(), before);
}

TEST(Playhead, PositionsLieBetweenFrames) {
    Chain chain;
    const ClipView clip = chain.asset.animation.clips[0];
    EXPECT_EQ(clipPosition(chain.asset.animation, clip, 2.0 / 3), (ClipPosition{2, 3, 0}));
    const ClipPosition between = clipPosition(chain.asset.animation, clip, 2.0 / 3 + 0.1);
    EXPECT_EQ(between.frame, 2u);
    EXPECT_NEAR(between.part, 0.3, 1e-9);
    for (const double number : {0.0, 2.25, 23.0})
        EXPECT_NEAR(positionSeconds(chain.asset.animation, clip, number), number / 3, 1e-12);
    const double last = 23.0 / 3;
    EXPECT_EQ(clipPosition(chain.asset.animation, clip, last).frame, 23u);
    EXPECT_EQ(clipPosition(chain.asset.animation, clip, last + 0.2), (ClipPosition{23, 23, 0})) << "nothing to go to";
    Playhead playhead{.time = last - 0.1, .playing = true, .smooth = true};
    advance(playhead, chain.asset.animation, clip, 0.15);
    EXPECT_NEAR(playhead.time, 0.05, 1e-9) << "smoothly there is no wait at the last frame";
}

}  // namespace
}  // namespace penumbra::test_pose_interpolation
