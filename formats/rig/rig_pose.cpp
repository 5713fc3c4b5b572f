// Poses a rig: keys give node transforms, and these give skinning matrices. Interpolation follows glTF 2.0, appendix
// C.
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "formats/common/errors.h"
#include "formats/rig/rig_keys.h"
#include "formats/rig/rig_matrix.h"
#include "formats/rig/rig_morphs.h"
#include "formats/rig/rig_poses.h"

namespace penumbra {

namespace {
template <std::size_t N>
std::array<double, N> keyValue(const float* key) {
    std::array<double, N> out;
    std::copy_n(key, N, out.begin());
    return out;
}

template <std::size_t N>
std::array<double, N> valueAt(const Channel& channel, double time) {
    const KeySpan span = findKeys(channel.times, time);
    const std::size_t stride = channel.interpolation == Interpolation::kCubicSpline ? 3 * N : N;
    const float *from = &channel.values[span.from * stride], *to = &channel.values[span.to * stride];
    if (channel.interpolation == Interpolation::kCubicSpline) {
        std::array<double, N> out;
        for (std::size_t i = 0; i < N; ++i) out[i] = cubicSpline(from, to, N, i, span);
        return out;
    }
    const std::array<double, N> a = keyValue<N>(from), b = keyValue<N>(to);
    if (channel.interpolation == Interpolation::kStep || span.fraction == 0) return a;
    if constexpr (N == 4) {
        return slerp(normalized(a).value_or(a), normalized(b).value_or(b), span.fraction);
    } else {
        std::array<double, N> out;
        for (std::size_t i = 0; i < N; ++i) out[i] = a[i] + span.fraction * (b[i] - a[i]);
        return out;
    }
}

std::vector<NodePose> posesOfNodes(const std::vector<Node>& nodes, const Clip* clip, double time) {
    std::vector<NodePose> poses;
    poses.reserve(nodes.size());
    for (const Node& node : nodes) poses.push_back({node.translation, node.rotation, node.scale});
    if (clip == nullptr) return poses;
    for (const Channel& channel : clip->channels) {
        NodePose& pose = poses[std::size_t(channel.node)];
        switch (channel.path) {
            case Channel::Path::kTranslation:
                pose.translation = valueAt<3>(channel, time);
                break;
            case Channel::Path::kRotation:  // a spline through opposite quaternions may pass through zero
                pose.rotation = normalized(valueAt<4>(channel, time)).value_or(pose.rotation);
                break;
            case Channel::Path::kScale:
                pose.scale = valueAt<3>(channel, time);
                break;
        }
    }
    return poses;
}

const Clip* clipOf(const Rig& rig, int clip) { return clip < 0 ? nullptr : &rig.clips.at(std::size_t(clip)); }

}  // namespace

std::vector<NodePose> nodePoses(const Rig& rig, RigFrame frame) {
    return posesOfNodes(rig.nodes, clipOf(rig, frame.clip), frame.time);
}

std::vector<Matrix> localTransforms(const std::vector<Node>& nodes, std::span<const NodePose> poses) {
    std::vector<Matrix> locals;
    locals.reserve(nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n)
        locals.push_back(nodes[n].matrix ? restTransform(nodes[n])
                                         : composeTransform(poses[n].translation, poses[n].rotation, poses[n].scale));
    return locals;
}

std::vector<Matrix> localTransforms(const std::vector<Node>& nodes, const Clip* clip, double time) {
    return localTransforms(nodes, posesOfNodes(nodes, clip, time));
}

std::vector<Matrix> globalTransforms(const std::vector<Node>& nodes, std::span<const NodePose> poses) {
    std::vector<Matrix> globals = localTransforms(nodes, poses);
    for (std::size_t n = 0; n < globals.size(); ++n)
        if (nodes[n].parent >= 0) globals[n] = multiply(globals[std::size_t(nodes[n].parent)], globals[n]);
    return globals;
}

namespace {

// Returns the rotation of `node` in the space of its nearest ancestor that is a joint (or of the scene).
Quaternion rotationToParentJoint(const Rig& rig, const std::vector<NodePose>& poses, int node, int stop) {
    Quaternion q{0, 0, 0, 1};
    for (int n = node; n >= 0 && n != stop; n = rig.nodes[std::size_t(n)].parent)
        if (!rig.nodes[std::size_t(n)].matrix) q = multiply(poses[std::size_t(n)].rotation, q);
    return q;
}

std::vector<float> rotationVectors(const Rig& rig, const std::vector<NodePose>& poses,
                                   const std::vector<NodePose>& rest) {
    std::vector<float> out;
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j) {
        const int parent = rig.skin.parents[j];
        const int stop = parent < 0 ? -1 : rig.node_of_joint[std::size_t(parent)];
        const Quaternion at_rest = rotationToParentJoint(rig, rest, rig.node_of_joint[j], stop);
        const Quaternion now = rotationToParentJoint(rig, poses, rig.node_of_joint[j], stop);
        const Vec3 v = toFloat(rotationVector(multiply(conjugate(at_rest), now)));
        out.insert(out.end(), {v.x, v.y, v.z});
    }
    return out;
}

}  // namespace

RigPose evaluatePose(const Rig& rig, int clip, double time) {
    const std::vector<NodePose> poses = nodePoses(rig, {clip, time});
    const std::vector<Matrix> globals = globalTransforms(rig.nodes, poses);
    RigPose pose;
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j) {
        const Matrix bone = multiply(globals[std::size_t(rig.node_of_joint[j])], rig.inverse_bind[j]);
        Affine affine;
        std::copy(bone.begin(), bone.end(), affine.m.begin());
        for (const float v : affine.m)
            if (!std::isfinite(v))
                throw InvalidInput(rig.files_read.at(0).string() + ": node '" + rig.skin.joint_names[j] +
                                   "': its transform is not finite at " + std::to_string(time) + " s");
        pose.bones.push_back(affine);
    }
    pose.pose = rotationVectors(rig, poses, nodePoses(rig, {}));
    pose.weights = weightsAt(rig, clip, time);
    return pose;
}

void appendValues(const NodePose& pose, std::vector<float>& out) {
    for (const double v : pose.translation) out.push_back(float(v));
    for (const double v : pose.rotation) out.push_back(float(v));
    for (const double v : pose.scale) out.push_back(float(v));
}

std::vector<NodePose> nodePosesOf(std::span<const float> values) {
    std::vector<NodePose> poses(values.size() / kNodeValues);
    for (std::size_t n = 0; n < poses.size(); ++n) {
        const float* from = &values[n * kNodeValues];
        std::copy_n(from, 3, poses[n].translation.begin());
        const Quaternion rotation{from[3], from[4], from[5], from[6]};
        poses[n].rotation = normalized(rotation).value_or(Quaternion{0, 0, 0, 1});
        std::copy_n(from + 7, 3, poses[n].scale.begin());
    }
    return poses;
}

// --- Poses as a clip ------------------------------------------------------------------------------------------------

namespace {

Channel stepChannel(int node, Channel::Path path, std::size_t keys) {
    Channel channel{node, path, Interpolation::kStep, {}, {}};
    for (std::size_t k = 0; k < keys; ++k) channel.times.push_back(double(k));
    channel.values.reserve(keys * (path == Channel::Path::kRotation ? 4 : 3));
    return channel;
}

void appendValue(const NodePose& pose, Channel& channel) {
    const auto append = [&](const auto& value) {
        for (const double v : value) channel.values.push_back(float(v));
    };
    if (channel.path == Channel::Path::kTranslation) append(pose.translation);
    if (channel.path == Channel::Path::kRotation) append(pose.rotation);
    if (channel.path == Channel::Path::kScale) append(pose.scale);
}

}  // namespace

Clip clipOfFrames(const Rig& rig, std::span<const RigFrame> frames, std::string name) {
    std::set<std::pair<int, Channel::Path>> moved;
    for (const RigFrame& frame : frames)
        if (frame.clip >= 0)
            for (const Channel& c : rig.clips.at(std::size_t(frame.clip)).channels) moved.emplace(c.node, c.path);
    // A clip must have a key, but the rest pose has none.
    for (std::size_t n = 0; moved.empty() && n < rig.nodes.size(); ++n)
        if (!rig.nodes[n].matrix) moved.emplace(int(n), Channel::Path::kRotation);
    Clip clip{std::move(name), double(frames.size() - 1), {}};
    for (const auto& [node, path] : moved) clip.channels.push_back(stepChannel(node, path, frames.size()));
    for (const RigFrame& frame : frames) {
        const std::vector<NodePose> poses = nodePoses(rig, frame);
        for (Channel& channel : clip.channels) appendValue(poses[std::size_t(channel.node)], channel);
    }
    return clip;
}

bool turnsItself(const Rig& rig, std::size_t joint) {
    const int node = rig.node_of_joint[joint];
    const auto first = std::find(rig.node_of_joint.begin(), rig.node_of_joint.end(), node);
    return first - rig.node_of_joint.begin() == std::ptrdiff_t(joint) && !rig.nodes[std::size_t(node)].matrix;
}

Clip clipOfRotations(const Rig& rig, std::span<const float> rotations, std::string name) {
    const std::size_t width = 3 * rig.skin.jointCount(), poses = rotations.size() / width;
    Clip clip{std::move(name), double(poses - 1), {}};
    for (std::size_t j = 0; j < rig.skin.jointCount(); ++j) {
        if (!turnsItself(rig, j)) continue;
        // The joint's rotation is its own, times those of the nodes between it and its parent joint, all of which are
        // at rest. Only its own factor changes, from q_rest to q_rest exp(v).
        const Quaternion& rest = rig.nodes[std::size_t(rig.node_of_joint[j])].rotation;
        clip.channels.push_back(stepChannel(rig.node_of_joint[j], Channel::Path::kRotation, poses));
        for (std::size_t p = 0; p < poses; ++p) {
            const float* v = &rotations[p * width + 3 * j];
            for (const double q : multiply(rest, rotationOf({v[0], v[1], v[2]})))
                clip.channels.back().values.push_back(float(q));
        }
    }
    return clip;
}

Clip clipOfNodes(const Rig& rig, std::span<const float> values, std::string name) {
    const std::size_t width = kNodeValues * rig.nodes.size(), poses = values.size() / width;
    Clip clip{std::move(name), double(poses - 1), {}};
    const std::vector<NodePose> rest = nodePoses(rig, {});
    for (std::size_t n = 0; n < rig.nodes.size(); ++n) {
        if (rig.nodes[n].matrix) continue;
        std::vector<float> at_rest;
        appendValues(rest[n], at_rest);
        for (const auto& [path, first, count] : {std::tuple(Channel::Path::kTranslation, 0, 3),
                                                 {Channel::Path::kRotation, 3, 4},
                                                 {Channel::Path::kScale, 7, 3}}) {
            Channel channel = stepChannel(int(n), path, poses);
            bool moves = clip.channels.empty() && path == Channel::Path::kRotation;  // a clip must have a key
            for (std::size_t p = 0; p < poses; ++p) {
                const float* from = &values[p * width + n * kNodeValues + std::size_t(first)];
                channel.values.insert(channel.values.end(), from, from + count);
                moves = moves || !std::equal(from, from + count, at_rest.begin() + first);
            }
            if (moves) clip.channels.push_back(std::move(channel));
        }
    }
    return clip;
}

}  // namespace penumbra
