// Finds feet.
//
// Problem: receivers beside a foot see little but the foot, so it needs spheres of its own, and rigs do not say which
// joints are feet. Names differ from rig to rig.
//
// Naive: the leaves of the skeleton that are lowest at rest. But toes are leaves and no feet, coats and tails hang
// lower than feet, and a rig may lie on its back at rest.
//
// Here: what touches the ground in the animation. In each pose the ground is where the lowest point is. A foot is a
// whole end of a limb (a joint with all that hangs from it) that is there in a good part of the poses. A shin is not:
// its knee never touches.
#include "fit/blockers/find_feet.h"

#include <algorithm>
#include <limits>

namespace penumbra {

namespace {

// Returns the share of the poses in which each joint has a point at the ground.
std::vector<double> touchingTime(const SurfaceSamples& samples, std::span<const Affine> bones, std::size_t joints,
                                 double touch) {
    std::vector<double> share(joints);
    const std::size_t poses = bones.size() / joints;
    for (std::size_t pose = 0; pose < poses; ++pose) {
        std::vector<Vec3> points;
        Vec3 low{1e30f, 1e30f, 1e30f}, high = -low;
        for (std::size_t i = 0; i < samples.points.size(); ++i) {
            points.push_back(bones[pose * joints + samples.joint[i]].point(toFloat(samples.points[i])));
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = std::min(low[axis], points.back()[axis]);
                high[axis] = std::max(high[axis], points.back()[axis]);
            }
        }
        std::vector<bool> touches(joints);
        const double reach = double(low.y) + touch * double(length(high - low));
        for (std::size_t i = 0; i < points.size(); ++i)
            if (double(points[i].y) <= reach) touches[samples.joint[i]] = true;
        for (std::size_t j = 0; j < joints; ++j) share[j] += touches[j] / double(poses);
    }
    return share;
}

// Calls visit(a) for a joint and for all joints above it.
template <class Visit>
void climb(std::span<const std::int32_t> parents, std::size_t joint, Visit visit) {
    for (std::int32_t a = std::int32_t(joint); a >= 0; a = parents[std::size_t(a)]) visit(std::size_t(a));
}

}  // namespace

std::vector<std::uint16_t> findFeet(const SurfaceSamples& samples, std::span<const std::int32_t> parents,
                                    std::span<const Affine> bones, const FootOptions& options) {
    const std::size_t joints = parents.size();
    std::vector<std::uint16_t> feet;
    if (bones.empty() || samples.points.empty()) return feet;
    const std::vector<double> time = touchingTime(samples, bones, joints, options.touch);
    // 1. A limb that holds a point of a joint that touches too rarely is no foot.
    std::vector<std::size_t> own(joints), below(joints);
    for (const std::uint16_t joint : samples.joint) ++own[joint];
    std::vector<bool> in_air(joints);
    for (std::size_t j = 0; j < joints; ++j)
        climb(parents, j, [&](std::size_t above) {
            below[above] += own[j];
            if (own[j] > 0 && time[j] < options.least_time) in_air[above] = true;
        });
    // 2. A foot is the highest joint of such a limb that owns a point itself.
    const auto stands = [&](std::size_t j) { return own[j] > 0 && !in_air[j]; };
    for (std::size_t j = 0; j < joints; ++j) {
        if (!stands(j) || double(below[j]) > options.most_area * double(samples.points.size())) continue;
        bool highest = true;
        climb(parents, j, [&](std::size_t above) { highest &= above == j || !stands(above); });
        if (highest) feet.push_back(std::uint16_t(j));
    }
    return feet;
}

std::vector<int> footOfJoint(std::span<const std::uint16_t> feet, std::span<const std::int32_t> parents) {
    std::vector<int> foot(parents.size(), -1);
    for (std::size_t j = 0; j < parents.size(); ++j)
        climb(parents, j, [&](std::size_t above) {
            const auto found = std::find(feet.begin(), feet.end(), above);
            if (found != feet.end()) foot[j] = int(found - feet.begin());
        });
    return foot;
}

}  // namespace penumbra
