#include "bake/poses/mix_poses.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bake/common/random_numbers.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

constexpr double kMaxShear = 1e-3;  // of the largest entry of the linear part
constexpr double kMaxMixedBytes = double(std::size_t(2) << 30);

std::vector<LimbChoice> chooseLimbs(const MixSource& source, std::uint64_t seed, std::size_t index) {
    std::uint64_t state = seed * 0x9e3779b97f4a7c15u + index;
    state = nextRandom(state);
    std::vector<LimbChoice> choices(source.limbs.count);
    for (std::size_t limb = 0; limb < choices.size(); ++limb) {
        choices[limb].frame = std::size_t(nextUniform(state) * double(source.frames.size()));
        choices[limb].mirrored = nextUniform(state) < 0.5 && source.limbs.mirrored_limb[limb] >= 0;
    }
    return choices;
}

namespace {

std::vector<Matrix> bonesOf(const Rig& rig, const std::vector<NodePose>& poses) {
    const std::vector<Matrix> globals = globalTransforms(rig.nodes, poses);
    std::vector<Matrix> bones;
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j)
        bones.push_back(multiply(globals[std::size_t(rig.node_of_joint[j])], rig.inverse_bind[j]));
    return bones;
}

// Returns S D S of joint j; null where a bone is scaled to nothing.
std::optional<Matrix> mirroredMove(const MixSource& source, const std::vector<Matrix>& bones, std::size_t j,
                                   const Matrix& at_rest) {
    const auto image = std::size_t(source.limbs.mirrored_joint[j]);
    const int parent = source.rig.skin.parents[image];
    const std::optional<Matrix> back = inverse(parent < 0 ? at_rest : bones[std::size_t(parent)]);
    if (!back) return std::nullopt;
    const Matrix& mirror = source.limbs.reflection;
    return multiply(multiply(mirror, multiply(*back, bones[image])), mirror);
}

// Returns the product of the transforms of the nodes strictly between `node` and the node `top` (-1: the scene).
Matrix transformBetween(const Rig& rig, const std::vector<NodePose>& poses, int node, int top) {
    Matrix product = kIdentityMatrix;
    for (int n = rig.nodes[std::size_t(node)].parent; n >= 0 && n != top; n = rig.nodes[std::size_t(n)].parent) {
        const NodePose& pose = poses[std::size_t(n)];
        const Node& at = rig.nodes[std::size_t(n)];
        product = multiply(
            at.matrix ? restTransform(at) : composeTransform(pose.translation, pose.rotation, pose.scale), product);
    }
    return product;
}

// Tells whether translation, rotation and scale give the matrix. Inverse bind matrices are floats in most files, often
// rounded further, so that a little shear is no more than their error.
bool fits(const Decomposition& parts, const Matrix& matrix) {
    const Matrix again = composeTransform(parts.translation, parts.rotation, parts.scale);
    double largest = 0, worst = 0;
    for (std::size_t i = 0; i < matrix.size(); ++i) {
        if (i % 4 < 3) largest = std::max(largest, std::abs(matrix[i]));
        worst = std::max(worst, std::abs(again[i] - matrix[i]));
    }
    return worst <= kMaxShear * largest;
}

// Returns the transform of the node of joint j with which `above` is the transform of the joint times its inverse bind
// matrix, seen from the node of the parent joint. Null where the node would have to shear.
std::optional<NodePose> poseForMove(const Rig& rig, const std::vector<NodePose>& poses, std::size_t j,
                                    const Matrix& above) {
    const int parent = rig.skin.parents[j], node = rig.node_of_joint[j];
    const std::optional<Matrix> between =
        inverse(transformBetween(rig, poses, node, parent < 0 ? -1 : rig.node_of_joint[std::size_t(parent)]));
    const std::optional<Matrix> bind = inverse(rig.inverse_bind[j]);
    if (!between || !bind) return std::nullopt;
    const Matrix wanted = multiply(*between, multiply(above, *bind));
    const Decomposition parts = decompose(wanted);
    if (!fits(parts, wanted)) return std::nullopt;
    return NodePose{parts.translation, parts.rotation, parts.scale};
}

// Poses one limb, whose joints are in an order in which parents come first, as the mirror image of its image. Returns
// false, with `poses` half changed, where that cannot be done.
bool mirrorLimb(const MixSource& source, int limb, const std::vector<NodePose>& frame, std::vector<NodePose>& poses) {
    const Rig& rig = source.rig;
    const std::vector<Matrix> bones = bonesOf(rig, frame);
    const std::vector<NodePose> rest = nodePoses(rig, {});
    const std::vector<Matrix> rest_bones = bonesOf(rig, rest);
    std::vector<int> joint_of_node(rig.nodes.size(), -1);
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j)
        if (source.limbs.carries[j]) joint_of_node[std::size_t(rig.node_of_joint[j])] = int(j);
    for (std::size_t n = 0; n < rig.nodes.size(); ++n) {  // parents come first
        if (source.limbs.limb_of_node[n] != limb) continue;
        poses[n] = rest[n];
        if (joint_of_node[n] < 0) continue;
        const auto j = std::size_t(joint_of_node[n]);
        const std::optional<Matrix> move = mirroredMove(source, bones, j, rest_bones[j]);
        if (!move) return false;
        const int parent = rig.skin.parents[j];
        const Matrix& above = parent < 0 ? rest_bones[j] : rig.inverse_bind[std::size_t(parent)];
        const std::optional<NodePose> pose = poseForMove(rig, poses, j, multiply(above, *move));
        if (!pose) return false;
        poses[n] = *pose;
    }
    return true;
}

}  // namespace

std::vector<NodePose> mixPose(const MixSource& source, std::span<const LimbChoice> choices) {
    std::vector<NodePose> poses(source.rig.nodes.size());
    // The trunk comes first. The nodes between it and another limb may be its own.
    for (std::size_t limb = 0; limb < choices.size(); ++limb) {
        const std::vector<NodePose> frame = nodePoses(source.rig, source.frames[choices[limb].frame]);
        if (choices[limb].mirrored && mirrorLimb(source, int(limb), frame, poses)) continue;
        for (std::size_t n = 0; n < poses.size(); ++n)
            if (source.limbs.limb_of_node[n] == int(limb)) poses[n] = frame[n];
    }
    return poses;
}

std::vector<float> mixPoses(const MixSource& source, std::size_t count, std::uint64_t seed, int threads) {
    const std::size_t width = source.rig.nodes.size() * kNodeValues;
    if (double(count) * double(width) * sizeof(float) > kMaxMixedBytes)
        throw BadOption("mix", std::to_string(count) + " mixed poses of " + std::to_string(source.rig.nodes.size()) +
                                   " nodes are too many (more than 2 GiB); mix or cover fewer");
    std::vector<float> out(count * width);
    parallelFor(count, threads, [&](std::size_t p) {
        throwIfInterrupted();
        std::vector<float> values;
        for (const NodePose& pose : mixPose(source, chooseLimbs(source, seed, p))) appendValues(pose, values);
        std::copy(values.begin(), values.end(), out.begin() + std::ptrdiff_t(p * width));
    });
    return out;
}

}  // namespace penumbra
