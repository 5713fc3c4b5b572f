#include "player/view/playback/pose_interpolation.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

constexpr std::size_t kPivotFrames = 256;  // pivots are found from at most so many frames, spread over the animation
// A weight against the squared turns of the joint. It pulls the pivot to the center of what the joint moves, and so
// chooses a point on the axis of a hinge, all of which stay where they are.
constexpr double kCenterWeight = 1e-4;

double determinant(const Mat3d& a) {
    const Mat3d c = cofactor(a);
    return a.m[0] * c.m[0] + a.m[1] * c.m[1] + a.m[2] * c.m[2];
}

Mat3d inverse(const Mat3d& a) {
    Mat3d out = transposed(cofactor(a));
    const double scale = 1 / determinant(a);
    for (double& m : out.m) m *= scale;
    return out;
}

Mat3d lerp(const Mat3d& a, const Mat3d& b, double t) {
    Mat3d out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = (1 - t) * a.m[i] + t * b.m[i];
    return out;
}

Vec3d lerp(Vec3d a, Vec3d b, double t) { return (1 - t) * a + t * b; }

// Tells whether a point's place can be found back from where the bone moves it.
bool invertible(const Affine& bone) {
    const Mat3d linear = toDouble(bone.linear());
    double size = 1;
    for (int row = 0; row < 3; ++row) size *= length(Vec3d{linear(row, 0), linear(row, 1), linear(row, 2)});
    return std::abs(determinant(linear)) > 1e-6 * size;
}

}  // namespace

// Finds the joints' parents. Joints below one that is scaled to nothing become roots.
void PoseInterpolation::findParents() {
    const std::size_t count = joints_.size();
    std::vector<bool> usable(count, true), placed(count, false);
    for (std::size_t i = 0; i < animation_->bones.size(); ++i)
        if (!invertible(animation_->bones[i])) usable[i % count] = false;
    for (std::size_t j = 0; j < count; ++j) {
        const int parent = animation_->parents.empty() ? -1 : animation_->parents[j];
        joints_[j].parent = parent >= 0 && usable[std::size_t(parent)] ? parent : -1;
    }
    while (order_.size() < count)  // there are no cycles, so every round places some joint
        for (std::size_t j = 0; j < count; ++j) {
            if (placed[j] || (joints_[j].parent >= 0 && !placed[std::size_t(joints_[j].parent)])) continue;
            placed[j] = true;
            order_.push_back(j);
        }
}

PoseInterpolation::Transform PoseInterpolation::relative(std::size_t frame, std::size_t joint) const {
    const std::span<const Affine> bones = animation_->bonesOf(frame);
    const Affine& own = bones[joint];
    const Transform moved{toDouble(own.linear()), toDouble(own.translation())};
    if (joints_[joint].parent < 0) return moved;
    const Affine& parent = bones[std::size_t(joints_[joint].parent)];
    const Mat3d back = inverse(toDouble(parent.linear()));
    return {back * moved.linear, back * (moved.translation - toDouble(parent.translation()))};
}

// Finds the point c that moves least about its mean place: least squares over frames of (A_f - mean A) c + (t_f -
// mean t) = 0, with the weight kCenterWeight for (c - center).
Vec3d PoseInterpolation::findPivot(std::size_t joint, Vec3d center) const {
    const std::size_t frames = animation_->frameCount(), used = std::min(frames, kPivotFrames);
    std::vector<Transform> motions;
    for (std::size_t i = 0; i < used; ++i) motions.push_back(relative(i * frames / used, joint));
    Transform mean{Mat3d{{}}, {}};
    for (const Transform& motion : motions) {
        for (std::size_t i = 0; i < 9; ++i) mean.linear.m[i] += motion.linear.m[i] / double(used);
        mean.translation += motion.translation / double(used);
    }
    Mat3d normal{{}};
    Vec3d right;
    const double weight = kCenterWeight * double(used);
    for (int i = 0; i < 3; ++i) normal(i, i) = weight;
    for (const Transform& motion : motions) {
        Mat3d turn;
        for (std::size_t i = 0; i < 9; ++i) turn.m[i] = motion.linear.m[i] - mean.linear.m[i];
        const Mat3d back = transposed(turn), square = back * turn;
        for (std::size_t i = 0; i < 9; ++i) normal.m[i] += square.m[i];
        right += back * (turn * center + motion.translation - mean.translation);
    }
    return center - inverse(normal) * right;
}

namespace {

// Moves centers to the weighted centroids of what the joints move. Assets of transfer do not store these.
void findCenters(const MeshView& mesh, std::vector<Vec3d>& centers) {
    std::vector<Vec3d> sums(centers.size());
    std::vector<double> weights(centers.size());
    for (std::size_t i = 0; i < mesh.skin_joints.size(); ++i) {
        const double weight = mesh.skin_weights[i];
        sums[mesh.skin_joints[i]] += toDouble(mesh.positions[i / std::size_t(mesh.influences)]) * weight;
        weights[mesh.skin_joints[i]] += weight;
    }
    for (std::size_t j = 0; j < centers.size(); ++j)
        if (weights[j] > 0) centers[j] = sums[j] / weights[j];
}

// Returns the centers of what the joints move; those that move nothing get the center of the whole mesh.
std::vector<Vec3d> jointCenters(const AssetView& asset) {
    Vec3d middle;
    for (const Vec3& p : asset.mesh.positions) middle += toDouble(p) / double(asset.mesh.positions.size());
    std::vector<Vec3d> centers(asset.animation.jointCount(), middle);
    if (asset.model.joint_centers.empty()) {
        findCenters(asset.mesh, centers);
        return centers;
    }
    for (std::size_t i = 0; i < asset.mesh.skin_joints.size(); ++i)
        if (asset.mesh.skin_weights[i] > 0)
            centers[asset.mesh.skin_joints[i]] = toDouble(asset.model.joint_centers[asset.mesh.skin_joints[i]]);
    return centers;
}

}  // namespace

// A root turns about its center, because the point that it moves least may be far away from the character.
PoseInterpolation::PoseInterpolation(const AssetView& asset)
    : animation_(&asset.animation), joints_(asset.animation.jointCount()) {
    findParents();
    const std::vector<Vec3d> centers = jointCenters(asset);
    for (std::size_t j = 0; j < joints_.size(); ++j)
        joints_[j].pivot = joints_[j].parent < 0 ? centers[j] : findPivot(j, centers[j]);
    motions_of_from_.resize(joints_.size());
    motions_of_to_.resize(joints_.size());
    now_.resize(joints_.size());
    bones_.resize(joints_.size());
    pose_.resize(animation_->pose.empty() ? 0 : animation_->pose_size);
}

void PoseInterpolation::readMotions(std::size_t frame, std::vector<Motion>& motions) const {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
        const Transform motion = relative(frame, j);
        Mat3 linear;
        for (std::size_t i = 0; i < 9; ++i) linear.m[i] = float(motion.linear.m[i]);
        const Mat3d rotation = toDouble(nearestRotation(linear));
        motions[j] = {quaternionOf(rotation), transposed(rotation) * motion.linear,
                      motion.linear * joints_[j].pivot + motion.translation};
    }
}

void PoseInterpolation::interpolateBones(double part) {
    for (const std::size_t j : order_) {
        const Motion &from = motions_of_from_[j], &to = motions_of_to_[j];
        Transform& now = now_[j];
        now.linear = matrixOf(slerp(from.rotation, to.rotation, part)) * lerp(from.stretch, to.stretch, part);
        now.translation = lerp(from.pivot, to.pivot, part) - now.linear * joints_[j].pivot;
        if (joints_[j].parent >= 0) {
            const Transform& parent = now_[std::size_t(joints_[j].parent)];
            now = {parent.linear * now.linear, parent.linear * now.translation + parent.translation};
        }
        for (std::size_t row = 0; row < 3; ++row) {
            for (std::size_t c = 0; c < 3; ++c) bones_[j].m[4 * row + c] = float(now.linear.m[3 * row + c]);
            bones_[j].m[4 * row + 3] = float(now.translation[int(row)]);
        }
    }
}

void PoseInterpolation::interpolateRotationVectors(double part) {
    const std::span<const float> a = animation_->poseOf(from_), b = animation_->poseOf(to_);
    // The inputs, such as weights of morph targets, come last and are no rotations.
    const std::size_t rotations = pose_.size() - std::min(pose_.size(), animation_->input_names.size());
    for (std::size_t i = rotations; i < pose_.size(); ++i) pose_[i] = float(a[i] + part * (double(b[i]) - a[i]));
    for (std::size_t i = 0; i + 3 <= rotations; i += 3) {
        const auto rotation = [&](std::span<const float> pose) {
            return rotationOf(toDouble(Vec3{pose[i], pose[i + 1], pose[i + 2]}));
        };
        const Vec3 v = toFloat(rotationVector(slerp(rotation(a), rotation(b), part)));
        for (int c = 0; c < 3; ++c) pose_[i + std::size_t(c)] = v[c];
    }
}

void PoseInterpolation::evaluate(std::size_t from, std::size_t to, double part) {
    if (part <= 0 || part >= 1) {
        const std::size_t frame = part <= 0 ? from : to;
        std::ranges::copy(animation_->bonesOf(frame), bones_.begin());
        std::ranges::copy(animation_->poseOf(frame), pose_.begin());
        return;
    }
    if (!has_motions_ || from != from_ || to != to_) {
        readMotions(from, motions_of_from_);
        readMotions(to, motions_of_to_);
        from_ = from;
        to_ = to;
        has_motions_ = true;
    }
    interpolateBones(part);
    interpolateRotationVectors(part);
}

}  // namespace penumbra
