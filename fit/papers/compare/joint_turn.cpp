#include <algorithm>
#include <cmath>

#include "fit/models/features.h"
#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/pca.h"
#include "fit/papers/compare/joint_sweep.h"

namespace penumbra {

namespace {

// Returns axis times angle of a rotation. Near half a turn the axis comes from R + I, whose columns lie along it.
Vec3d rotationLog(const Mat3d& r) {
    const Vec3d twice{r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)};  // 2 sin(angle) axis
    const double cosine = std::clamp((r(0, 0) + r(1, 1) + r(2, 2) - 1) / 2, -1.0, 1.0);
    const double sine = length(twice) / 2, angle = std::atan2(sine, cosine);
    if (sine > 1e-6) return twice * (angle / (2 * sine));
    if (cosine > 0) return twice * 0.5;
    int k = 0;
    for (int i = 1; i < 3; ++i)
        if (r(i, i) > r(k, k)) k = i;
    Vec3d axis{r(0, k), r(1, k), r(2, k)};
    axis[k] += 1;
    return normalized(axis) * angle;
}

Mat3d rotationExp(Vec3d w) {
    const double angle = length(w), c = std::cos(angle), s = std::sin(angle), t = 1 - c;
    const Vec3d u = normalized(w);
    return {{c + t * u.x * u.x, t * u.x * u.y - s * u.z, t * u.x * u.z + s * u.y,  //
             t * u.x * u.y + s * u.z, c + t * u.y * u.y, t * u.y * u.z - s * u.x,  //
             t * u.x * u.z - s * u.y, t * u.y * u.z + s * u.x, c + t * u.z * u.z}};
}

Vec3d apply(const Affine& a, Vec3d p) { return toDouble(a.linear()) * p + toDouble(a.translation()); }

// Returns the point c that minimises sum_f |M_joint c - M_parent c|^2. Along a hinge, where the sum leaves c open, it
// stays near `guess`.
Vec3d fitPivot(const PoseTable& poses, std::span<const std::size_t> frames, std::pair<int, int> joints, Vec3d guess) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Identity() * (1e-9 * double(frames.size()));
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t f : frames) {
        const Affine& parent = poses.bonesOf(f)[std::size_t(joints.first)];
        const Affine& joint = poses.bonesOf(f)[std::size_t(joints.second)];
        Eigen::Matrix3d difference;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                difference(r, c) = double(joint.m[std::size_t(4 * r + c)]) - double(parent.m[std::size_t(4 * r + c)]);
        const Vec3d at_guess = apply(joint, guess) - apply(parent, guess);
        normal += difference.transpose() * difference;
        right -= difference.transpose() * Eigen::Vector3d(at_guess.x, at_guess.y, at_guess.z);
    }
    const Eigen::Vector3d step = solveSemidefinite(normal, right);
    return guess + Vec3d{step.x(), step.y(), step.z()};
}

Vec3d meanOf(std::span<const Vec3d> rotations, std::size_t joints, std::size_t joint,
             std::span<const std::size_t> frames) {
    Vec3d sum;
    for (std::size_t f : frames) sum += rotations[f * joints + joint];
    return sum / double(frames.size());
}

// Returns the change of the joint's three numbers of the pose vector for a radian. They turn with the joint's rotation:
// v = Q w with one rotation Q for all frames. So the regression of v on the angle about a principal axis a of w is Q a.
Vec3d poseAxis(const PoseTable& poses, std::size_t joint, std::span<const std::size_t> frames,
               std::span<const double> angles) {
    if (poses.pose_size != 3 * poses.joints) return {};
    double mean_angle = 0, spread = 0;
    for (std::size_t f : frames) mean_angle += angles[f] / double(frames.size());
    Vec3d sum;
    for (std::size_t f : frames) {
        const float* v = poses.poseOf(f).data() + 3 * joint;
        sum += Vec3d{v[0], v[1], v[2]} * (angles[f] - mean_angle);
        spread += (angles[f] - mean_angle) * (angles[f] - mean_angle);
    }
    return spread > 0 ? normalized(sum / spread) : Vec3d{};
}

// Returns the frame in which all joints but one are nearest to their mean rotations.
std::size_t nearestToMeans(std::span<const Vec3d> rotations, std::size_t joints, std::size_t but,
                           std::span<const std::size_t> frames) {
    std::vector<double> distance(frames.size());
    for (std::size_t j = 0; j < joints; ++j) {
        if (j == but) continue;
        const Vec3d mean = meanOf(rotations, joints, j, frames);
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const Vec3d d = rotations[frames[i] * joints + j] - mean;
            distance[i] += dot(d, d);
        }
    }
    return frames[std::size_t(std::min_element(distance.begin(), distance.end()) - distance.begin())];
}

bool movesWith(const std::vector<std::int32_t>& parents, std::size_t joint, int ancestor) {
    for (std::int32_t j = std::int32_t(joint); j >= 0; j = parents[std::size_t(j)])
        if (j == ancestor) return true;
    return false;
}

}  // namespace

std::vector<Vec3d> relativeRotations(const PoseTable& poses, const std::vector<std::int32_t>& parents) {
    std::vector<Vec3d> out(poses.rotations.size());
    for (std::size_t f = 0; f < poses.frameCount(); ++f)
        for (std::size_t j = 0; j < poses.joints; ++j) {
            if (parents[j] < 0) continue;
            const Mat3d parent = toDouble(poses.rotationsOf(f)[std::size_t(parents[j])]);
            out[f * poses.joints + j] = rotationLog(transposed(parent) * toDouble(poses.rotationsOf(f)[j]));
        }
    return out;
}

Vec3d principalTurn(std::span<const Vec3d> rotations, std::size_t joints, std::size_t joint,
                    std::span<const std::size_t> frames) {
    std::vector<Vec3> points;
    for (std::size_t f : frames) points.push_back(toFloat(rotations[f * joints + joint]));
    return principalAxes(points)[0];
}

JointTurn makeJointTurn(const CompareInput& input, const CompareCharacter& character, int joint) {
    const PoseTable& poses = input.poses;
    const auto own = std::size_t(joint);
    const std::vector<Vec3d> rotations = relativeRotations(poses, poses.skin.parents);
    JointTurn turn;
    turn.joint = joint;
    turn.axis = principalTurn(rotations, poses.joints, own, character.train);
    turn.base_frame = nearestToMeans(rotations, poses.joints, own, character.train);
    turn.base_angle = dot(turn.axis, rotations[turn.base_frame * poses.joints + own]);
    const Vec3d guess = toDouble(poses.joint_centers[own]);
    turn.pivot = fitPivot(poses, character.train, {poses.skin.parents[own], joint}, guess);
    std::vector<double> angles;
    for (std::size_t f = 0; f < poses.frameCount(); ++f)
        angles.push_back(dot(turn.axis, rotations[f * poses.joints + own]));
    turn.pose_axis = poseAxis(poses, own, character.train, angles);
    return turn;
}

TurnedPose poseAt(const CompareInput& input, const JointTurn& turn, double angle) {
    const PoseTable& poses = input.poses;
    const std::vector<std::int32_t>& parents = input.poses.skin.parents;
    const std::size_t f = turn.base_frame;
    const auto joint = std::size_t(turn.joint), parent = std::size_t(parents[joint]);
    // 1. The rotation in the model frame that takes the joint from its angle in the base frame to the asked one.
    const Mat3d rest_to_model = toDouble(poses.rotationsOf(f)[parent]);
    const Mat3d before = transposed(rest_to_model) * toDouble(poses.rotationsOf(f)[joint]);
    const Mat3d after = rotationExp(rotationLog(before) + turn.axis * (angle - turn.base_angle));
    const Mat3d rotate = rest_to_model * after * transposed(before) * transposed(rest_to_model);
    const Vec3d center = apply(poses.bonesOf(f)[parent], turn.pivot);
    TurnedPose turned{{poses.bonesOf(f).begin(), poses.bonesOf(f).end()},
                      {poses.poseOf(f).begin(), poses.poseOf(f).end()}};
    // 2. Turn the joint and all that hangs on it about the pivot.
    for (std::size_t j = 0; j < poses.joints; ++j) {
        if (!movesWith(parents, j, turn.joint)) continue;
        const Mat3d linear = rotate * toDouble(turned.bones[j].linear());
        const Vec3d moved = rotate * (toDouble(turned.bones[j].translation()) - center) + center;
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) turned.bones[j].m[std::size_t(4 * r + c)] = float(linear(r, c));
            turned.bones[j].m[std::size_t(4 * r + 3)] = float(moved[r]);
        }
    }
    // 3. Change the joint's numbers of the pose vector.
    if (turn.pose_axis != Vec3d{})
        for (int i = 0; i < 3; ++i)
            turned.pose[3 * joint + std::size_t(i)] += float(turn.pose_axis[i] * (angle - turn.base_angle));
    return turned;
}

}  // namespace penumbra
