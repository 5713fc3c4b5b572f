// Compares the rest poses of two skeletons, and makes of them what moves the keys of one to the other.
//
// Problem: a clip file states where its joints are and how they turn, relative to their parents. Copied to another rig
// these numbers are right only if units, axes and the nodes between joints are the same.
//
// Naive: copy them. A clip in centimetres then throws a rig in metres 100 times as far, and a skeleton with other axes
// is twisted.
//
// Here: the rest poses tell what is different. Where joints have the same axes at rest, rotations are copied. Where the
// bones point the same ways and only the axes of joints differ, each rotation is turned from the one to the other
// (rig_retarget.h has the formula). Where a clip's nodes stand in its first frame instead of a rest pose, the places of
// children in the axes of their joints tell that the axes are the same. All else is refused, because no rule tells what
// the animator wants.
#include "formats/rig/rig_retarget.h"

#include <algorithm>
#include <cmath>

#include "formats/rig/rig_skeletons.h"

namespace penumbra {

namespace {

Quaternion orIdentity(Quaternion q) {
    if (q[3] < 0)
        for (double& v : q) v = -v;
    const bool is_rounding = std::abs(q[0]) < 1e-6 && std::abs(q[1]) < 1e-6 && std::abs(q[2]) < 1e-6;
    return is_rounding ? Quaternion{0, 0, 0, 1} : q;
}

// `length` is that of a rounding error.
Matrix orIdentity(const Matrix& m, double length) {
    for (std::size_t i = 0; i < m.size(); ++i)
        if (!(std::abs(m[i] - kIdentityMatrix[i]) < (i % 4 == 3 ? length : 1e-5))) return m;
    return kIdentityMatrix;
}

double scaleOf(const Matrix& m) { return std::cbrt(std::abs(determinant(m))); }

// Returns the rest transform from a node's parent to `ancestor`, or to the scene.
std::optional<Matrix> betweenThem(const std::vector<Node>& nodes, const RestPose& rest, std::size_t node,
                                  int ancestor) {
    const int parent = nodes[node].parent;
    if (parent == ancestor) return kIdentityMatrix;
    const Matrix& of_parent = rest.globals[std::size_t(parent)];
    if (ancestor < 0) return of_parent;
    const std::optional<Matrix> to_ancestor = inverse(rest.globals[std::size_t(ancestor)]);
    if (!to_ancestor) return std::nullopt;
    return multiply(*to_ancestor, of_parent);
}

Quaternion axesOf(const Skeletons& s, Relation relation, int n) {
    if (relation != Relation::kOtherAxes || n < 0) return {0, 0, 0, 1};
    return multiply(conjugate(s.clip_rest.rotations[s.clipNode(n)]), s.rig_rest.rotations[std::size_t(n)]);
}

// Tells whether a joint takes the clip's positions as they are: at the top, and where the clip's rest pose is unknown
// all the way down to the first fork.
bool takesPositions(const Skeletons& s, Relation relation, std::size_t n) {
    if (relation == Relation::kNoRest) return true;
    if (relation == Relation::kInClip)
        for (int up = s.parent[n]; up >= 0; up = s.parent[std::size_t(up)])
            if (std::count(s.parent.begin(), s.parent.end(), up) > 1) return false;
    return relation == Relation::kInClip || s.parent[n] < 0;
}

// Returns what maps positions of the clip's joint to those of the rig's joint n, or nothing where a scale is 0.
std::optional<Matrix> positionMap(const Skeletons& s, Relation relation, double ratio, std::size_t n) {
    const std::size_t c = s.clipNode(int(n));
    const int up = s.parent[n], clip_up = up < 0 ? -1 : s.clip_of[std::size_t(up)];
    const auto of_rig = betweenThem(s.rig.nodes, s.rig_rest, n, up);
    const auto of_clip = betweenThem(s.from.nodes, s.clip_rest, c, clip_up);
    const std::optional<Matrix> to_node = of_rig ? inverse(*of_rig) : std::nullopt;
    if (!to_node || !of_clip) return std::nullopt;
    double k = ratio;
    if (up >= 0) k *= scaleOf(s.clip_rest.globals[std::size_t(clip_up)]) / scaleOf(s.rig_rest.globals[std::size_t(up)]);
    if (!std::isfinite(k) || k == 0) return std::nullopt;
    const Matrix turn = composeTransform({}, conjugate(axesOf(s, relation, up)), {k, k, k});
    Matrix map = multiply(*to_node, multiply(turn, *of_clip));
    if (takesPositions(s, relation, n)) return map;
    for (const std::size_t i : {3, 7, 11}) map[i] = 0;
    const std::array<double, 3>&rest = s.rig.nodes[n].translation, &clip_rest = s.from.nodes[c].translation;
    const Vec3d at = transformPoint(map, {clip_rest[0], clip_rest[1], clip_rest[2]});
    map[3] = rest[0] - at.x;
    map[7] = rest[1] - at.y;
    map[11] = rest[2] - at.z;
    return map;
}

Quaternion rotationBefore(const Skeletons& s, Relation relation, std::size_t n) {
    const int up = s.parent[n], clip_up = up < 0 ? -1 : s.clip_of[std::size_t(up)];
    const auto of_rig = betweenThem(s.rig.nodes, s.rig_rest, n, up);
    const auto of_clip = betweenThem(s.from.nodes, s.clip_rest, s.clipNode(int(n)), clip_up);
    if (!of_rig || !of_clip) return {0, 0, 0, 1};
    return multiply(conjugate(decompose(*of_rig).rotation),
                    multiply(conjugate(axesOf(s, relation, up)), decompose(*of_clip).rotation));
}

}  // namespace

Retarget::Retarget(RigSource& rig, const RigSource& from, std::vector<int> clip_of) : joints_(rig.nodes.size()) {
    const Skeletons s = skeletonsOf(rig, from, clip_of);
    const Relation relation = relationOf(s);
    const double ratio = sizeRatio(s, relation);
    sayDifferences(s, relation, ratio, rig.notes);
    if (relation == Relation::kNoRest) return;
    for (std::size_t n = 0; n < clip_of.size(); ++n) {
        if (clip_of[n] < 0) continue;
        Joint& joint = joints_[n];
        joint.before = orIdentity(rotationBefore(s, relation, n));
        joint.after = orIdentity(axesOf(s, relation, int(n)));
        const double rounding = 1e-5 * std::max(s.rig_size, length(s.rig_rest.positions[n]));
        joint.position = orIdentity(positionMap(s, relation, ratio, n).value_or(kIdentityMatrix), rounding);
        const std::array<double, 3>& clip_scale = from.nodes[s.clipNode(int(n))].scale;
        for (std::size_t i = 0; i < 3; ++i) {
            const double by = rig.nodes[n].scale[i] / clip_scale[i];
            if (std::isfinite(by) && by != 0 && std::abs(by - 1) > 1e-5) joint.scale[i] = by;
        }
    }
}

Channel Retarget::channelOf(const Channel& channel, int n) const {
    const Joint& joint = joints_[std::size_t(n)];
    Channel out = channel;
    out.node = n;
    const std::size_t width = channel.path == Channel::Path::kRotation ? 4 : 3;
    const bool spline = channel.interpolation == Interpolation::kCubicSpline;
    for (std::size_t i = 0; i + width <= out.values.size(); i += width) {
        float* v = &out.values[i];
        const bool is_tangent = spline && i / width % 3 != 1;
        if (channel.path == Channel::Path::kScale) {
            for (std::size_t k = 0; k < 3; ++k)
                if (joint.scale[k] != 1) v[k] = float(v[k] * joint.scale[k]);
        } else if (channel.path == Channel::Path::kTranslation && joint.position != kIdentityMatrix) {
            Vec3d p = transformPoint(joint.position, {v[0], v[1], v[2]});
            if (is_tangent) p = p - Vec3d{joint.position[3], joint.position[7], joint.position[11]};
            std::copy_n(std::array{float(p.x), float(p.y), float(p.z)}.begin(), 3, v);
        } else if (channel.path == Channel::Path::kRotation &&
                   (joint.before != Quaternion{0, 0, 0, 1} || joint.after != Quaternion{0, 0, 0, 1})) {
            const Quaternion q = multiply(joint.before, multiply({v[0], v[1], v[2], v[3]}, joint.after));
            for (std::size_t k = 0; k < 4; ++k) v[k] = float(q[k]);
        }
    }
    return out;
}

}  // namespace penumbra
