#include "formats/rig/rig_skeletons.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "formats/common/errors.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

constexpr double kAxesTolerance = 10;  // degrees: joints of one family of characters differ by so much at rest
constexpr double kSaidAxes = 2;        // degrees: more is said
constexpr double kSameDirection = 20;  // degrees: characters have wide and narrow hips
constexpr double kLongBone = 0.1;      // in extents of the skeleton: shorter bones tell no direction
constexpr double kAnyBone = 0.01;      // in extents: shorter bones do not count as bones
constexpr double kSameSize = 2e-3;     // sizes nearer to 1 are rounding
constexpr int kFewConfirmed = 3;       // so many joints must tell that only their axes differ

RestPose restPoseOf(const std::vector<Node>& nodes) {
    RestPose rest{restGlobals(nodes), {}, {}};
    for (const Matrix& m : rest.globals) {
        rest.rotations.push_back(decompose(m).rotation);
        rest.positions.push_back({m[3], m[7], m[11]});
    }
    return rest;
}

Vec3d turned(const Quaternion& q, Vec3d v) {
    const Mat3d m = matrixOf(q);
    return {m(0, 0) * v.x + m(0, 1) * v.y + m(0, 2) * v.z, m(1, 0) * v.x + m(1, 1) * v.y + m(1, 2) * v.z,
            m(2, 0) * v.x + m(2, 1) * v.y + m(2, 2) * v.z};
}

double degreesBetween(const Quaternion& a, const Quaternion& b) {
    return degrees(length(rotationVector(multiply(conjugate(a), b))));
}

double degreesBetween(Vec3d a, Vec3d b) { return degrees(std::atan2(length(cross(a, b)), dot(a, b))); }

int matchedAncestor(const std::vector<Node>& nodes, int n, const std::vector<bool>& matched) {
    int up = nodes[std::size_t(n)].parent;
    while (up >= 0 && !matched[std::size_t(up)]) up = nodes[std::size_t(up)].parent;
    return up;
}

// Finds the matched ancestors in both files, which must be each other's.
void findParents(Skeletons& s) {
    std::vector<bool> in_rig(s.rig.nodes.size()), in_clip(s.from.nodes.size());
    for (std::size_t n = 0; n < s.clip_of.size(); ++n)
        if (s.clip_of[n] >= 0) in_rig[n] = in_clip[std::size_t(s.clip_of[n])] = true;
    s.parent.assign(s.clip_of.size(), -1);
    for (std::size_t n = 0; n < s.clip_of.size(); ++n) {
        if (s.clip_of[n] < 0) continue;
        const int up = s.parent[n] = matchedAncestor(s.rig.nodes, int(n), in_rig);
        const int clip_up = matchedAncestor(s.from.nodes, s.clip_of[n], in_clip);
        if (clip_up == (up < 0 ? -1 : s.clip_of[std::size_t(up)])) continue;
        const auto owner = [](const std::vector<Node>& nodes, int node) {
            return node < 0 ? std::string("no joint") : "'" + nodes[std::size_t(node)].name + "'";
        };
        failAtFile(s.from.file, "its node '" + s.from.nodes[s.clipNode(int(n))].name + "' hangs on " +
                                    owner(s.from.nodes, clip_up) + ", but '" + s.name(int(n)) + "' of " +
                                    s.rig.file.string() + " on " + owner(s.rig.nodes, up));
    }
}

void findBones(Skeletons& s) {
    std::vector<Vec3> of_rig, of_clip;
    for (std::size_t n = 0; n < s.clip_of.size(); ++n) {
        if (s.clip_of[n] < 0) continue;
        of_rig.push_back(toFloat(s.rig_rest.positions[n]));
        of_clip.push_back(toFloat(s.clip_rest.positions[s.clipNode(int(n))]));
    }
    s.rig_extent = of_rig.empty() ? 0 : boxDiagonal(of_rig);
    s.clip_extent = of_clip.empty() ? 0 : boxDiagonal(of_clip);
    for (std::size_t n = 0; n < s.clip_of.size(); ++n) {
        if (s.clip_of[n] < 0 || s.parent[n] < 0) continue;
        const int up = s.parent[n];
        const Bone bone{up, int(n), s.rig_rest.positions[n] - s.rig_rest.positions[std::size_t(up)],
                        s.clip_rest.positions[s.clipNode(int(n))] - s.clip_rest.positions[s.clipNode(up)]};
        s.rig_size += length(bone.of_rig);
        s.clip_size += length(bone.of_clip);
        s.bones.push_back(bone);
    }
}

bool isLong(const Skeletons& s, const Bone& bone) {
    return length(bone.of_rig) > kLongBone * s.rig_extent && length(bone.of_clip) > kLongBone * s.clip_extent;
}

// Tells whether all nodes that the clip moves stand at their parent's place, as where a file has no rest pose.
bool hasNoRest(const Skeletons& s) {
    for (const int n : s.clip_of)
        if (n >= 0 && restTransform(s.from.nodes[std::size_t(n)]) != kIdentityMatrix) return false;
    for (std::size_t n = 0; n < s.clip_of.size(); ++n)
        if (s.clip_of[n] >= 0 && restTransform(s.rig.nodes[n]) != kIdentityMatrix) return true;
    return false;
}

// --- What differs ---------------------------------------------------------------------------------------------------

struct Difference {
    int node = -1;
    double degrees = 0;
};

// Returns the joints that are turned against their parent joint (or the scene), the largest difference first.
std::vector<Difference> turnedJoints(const Skeletons& s, double at_least) {
    std::vector<Difference> list;
    for (std::size_t n = 0; n < s.clip_of.size(); ++n) {
        if (s.clip_of[n] < 0 || !s.rotates[s.clipNode(int(n))]) continue;
        Quaternion of_rig = s.rig_rest.rotations[n], of_clip = s.clip_rest.rotations[s.clipNode(int(n))];
        if (const int up = s.parent[n]; up >= 0) {
            of_rig = multiply(conjugate(s.rig_rest.rotations[std::size_t(up)]), of_rig);
            of_clip = multiply(conjugate(s.clip_rest.rotations[s.clipNode(up)]), of_clip);
        }
        if (const double by = degreesBetween(of_rig, of_clip); by > at_least) list.push_back({int(n), by});
    }
    std::stable_sort(list.begin(), list.end(), [](auto& a, auto& b) { return a.degrees > b.degrees; });
    return list;
}

// Returns the angle between a bone's directions, seen in the model frame or in the axes of the joint that it begins at.
enum class Seen : std::uint8_t { kInModel, kInJoint };
double degreesOf(const Skeletons& s, const Bone& bone, Seen seen) {
    if (seen == Seen::kInModel) return degreesBetween(bone.of_rig, bone.of_clip);
    return degreesBetween(turned(conjugate(s.rig_rest.rotations[std::size_t(bone.parent)]), bone.of_rig),
                          turned(conjugate(s.clip_rest.rotations[s.clipNode(bone.parent)]), bone.of_clip));
}

// Returns the long bones that point another way, the largest difference first.
std::vector<Difference> turnedBones(const Skeletons& s, Seen seen, double at_least) {
    std::vector<Difference> list;
    for (const Bone& bone : s.bones) {
        if (!isLong(s, bone)) continue;
        if (const double by = degreesOf(s, bone, seen); by > at_least) list.push_back({bone.child, by});
    }
    std::stable_sort(list.begin(), list.end(), [](auto& a, auto& b) { return a.degrees > b.degrees; });
    return list;
}

// Tells whether all joints are turned alike, by a rotation that takes axes to axes. So is a file whose up axis is
// another one, if its writer has turned the joints and not only the scene.
bool haveCommonAxes(const Skeletons& s) {
    std::optional<Quaternion> common;
    for (std::size_t n = 0; n < s.clip_of.size(); ++n) {
        if (s.clip_of[n] < 0) continue;
        const Quaternion axes = multiply(conjugate(s.clip_rest.rotations[s.clipNode(int(n))]), s.rig_rest.rotations[n]);
        if (!common) common = axes;
        if (degreesBetween(*common, axes) > kSaidAxes) return false;
    }
    if (!common) return false;
    for (const double v : matrixOf(*common).m)
        if (std::abs(v) > 0.03 && std::abs(v) < 0.97) return false;
    return std::any_of(s.bones.begin(), s.bones.end(), [&](const Bone& bone) { return isLong(s, bone); });
}

// Tells whether the places of children explain how joints are turned: at three joints or more and at half of those that
// are turned in the model frame or against their parent joint, a bone points the same way, seen likewise.
bool areConfirmed(const Skeletons& s, Seen seen, const std::vector<Difference>& against_parents) {
    if (seen == Seen::kInModel && haveCommonAxes(s)) return true;
    std::vector<bool> turned_here(s.clip_of.size()), confirmed(s.clip_of.size());
    for (const Difference& joint : against_parents) turned_here[std::size_t(joint.node)] = true;
    for (std::size_t n = 0; n < s.clip_of.size() && seen == Seen::kInModel; ++n)
        turned_here[n] =
            s.clip_of[n] >= 0 &&
            degreesBetween(s.rig_rest.rotations[n], s.clip_rest.rotations[s.clipNode(int(n))]) > kAxesTolerance;
    for (const Bone& bone : s.bones) {
        const std::size_t n = std::size_t(bone.parent);
        const bool has_length =
            length(bone.of_rig) > kAnyBone * s.rig_extent && length(bone.of_clip) > kAnyBone * s.clip_extent;
        if (turned_here[n] && has_length && degreesOf(s, bone, seen) < kSameDirection) confirmed[n] = true;
    }
    const auto count = std::count(confirmed.begin(), confirmed.end(), true);
    return count >= kFewConfirmed && 2 * count >= std::count(turned_here.begin(), turned_here.end(), true);
}

// Tells whether the nodes that are turned at rest stand as in the first key of a clip.
bool standsInClip(const Skeletons& s, const std::vector<Difference>& turned_joints) {
    for (const Difference& joint : turned_joints) {
        const std::size_t node = s.clipNode(joint.node);
        bool found = false;
        for (const Clip& clip : s.from.clips)
            for (const Channel& channel : clip.channels) {
                if (std::size_t(channel.node) != node || channel.path != Channel::Path::kRotation) continue;
                const float* v = &channel.values[channel.interpolation == Interpolation::kCubicSpline ? 4 : 0];
                const auto first = normalized({v[0], v[1], v[2], v[3]});
                found = found || (first && degreesBetween(*first, s.from.nodes[node].rotation) < 0.5);
            }
        if (!found) return false;
    }
    return true;
}

[[noreturn]] void refuse(const Skeletons& s, const std::vector<Difference>& list, const char* what) {
    std::string joints;
    for (std::size_t i = 0; i < std::min<std::size_t>(list.size(), 5); ++i) {
        const std::string by = std::to_string(std::lround(list[i].degrees));
        joints += (i == 0 ? "'" : ", '") + s.name(list[i].node) + "' by " + by + " degrees";
    }
    if (list.size() > 5) joints += " and " + std::to_string(list.size() - 5) + " more";
    failAtFile(s.from.file, "its rest pose is not that of " + s.rig.file.string() + ": " + what + joints +
                                " (bring the clip to the rig's rest pose where it was made)");
}

std::string threeDigits(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

}  // namespace

Skeletons skeletonsOf(const RigSource& rig, const RigSource& from, const std::vector<int>& clip_of) {
    Skeletons s{rig, from, clip_of, restPoseOf(rig.nodes), restPoseOf(from.nodes), {}, {}, {}};
    s.rotates.resize(from.nodes.size());
    for (const Clip& clip : from.clips)
        for (const Channel& channel : clip.channels)
            if (channel.path == Channel::Path::kRotation) s.rotates[std::size_t(channel.node)] = true;
    findParents(s);
    findBones(s);
    return s;
}

bool longBonesAgree(const Skeletons& s, const std::function<Vec3d(Vec3d)>& turn) {
    bool any = false;
    for (const Bone& bone : s.bones) {
        if (!isLong(s, bone)) continue;
        if (degreesBetween(bone.of_rig, turn(bone.of_clip)) > kSameDirection) return false;
        any = true;
    }
    return any;
}

Relation relationOf(const Skeletons& s) {
    if (hasNoRest(s)) return Relation::kNoRest;
    const std::vector<Difference> joints = turnedJoints(s, kAxesTolerance);
    const std::vector<Difference> bones = turnedBones(s, Seen::kInModel, kSameDirection);
    if (joints.empty()) {
        if (!bones.empty()) refuse(s, bones, "the bones before these joints are turned: ");
        return Relation::kSameAxes;
    }
    if (areConfirmed(s, Seen::kInModel, joints) && turnedBones(s, Seen::kInModel, kAxesTolerance).empty())
        return Relation::kOtherAxes;
    if (standsInClip(s, joints) && areConfirmed(s, Seen::kInJoint, joints) &&
        turnedBones(s, Seen::kInJoint, kAxesTolerance).empty())
        return Relation::kInClip;
    refuse(s, joints, "these joints are turned: ");
}

double sizeRatio(const Skeletons& s, Relation relation) {
    if (relation == Relation::kNoRest) return 1;
    const bool has_bones = s.rig_size > 0 && s.clip_size > 0;
    double ratio = has_bones ? s.rig_size / s.clip_size : 1;
    for (std::size_t n = 0; n < s.clip_of.size() && relation != Relation::kInClip; ++n) {
        if (s.clip_of[n] < 0) continue;
        const double of_rig = s.rig_rest.positions[n].y, of_clip = s.clip_rest.positions[s.clipNode(int(n))].y;
        if (!(of_rig > 0.1 * s.rig_extent && of_clip > 0.1 * s.clip_extent && of_rig > 0 && of_clip > 0)) continue;
        // The length of the legs decides between characters of different proportions, unless the clip's whole scene is
        // raised.
        if (!has_bones || std::abs(std::log(of_rig / of_clip / ratio)) < std::log(1.5)) ratio = of_rig / of_clip;
        break;
    }
    return std::abs(ratio - 1) < kSameSize ? 1 : ratio;
}

void sayDifferences(const Skeletons& s, Relation relation, double ratio, std::vector<RigNote>& notes) {
    const std::string file = s.from.file.string();
    if (relation == Relation::kNoRest)
        notes.push_back({file, "", "no rest pose", "its keys are taken as they are, in the axes of the rig's joints"});
    if (relation == Relation::kInClip)
        notes.push_back(
            {file, "", "no rest pose", "its nodes stand in the first frame of a clip; bones tell the size"});
    if (relation == Relation::kOtherAxes)
        notes.push_back({file, "", "other axes of joints", "rotations are turned to the axes of the rig's joints"});
    if (ratio != 1)
        notes.push_back({file, "", "another size", "its positions are multiplied by " + threeDigits(ratio)});
    if (relation == Relation::kSameAxes)
        if (const auto joints = turnedJoints(s, kSaidAxes); !joints.empty())
            notes.push_back({file, s.name(joints[0].node), "turned at rest",
                             "by " + threeDigits(joints[0].degrees) + " degrees (" + std::to_string(joints.size()) +
                                 " joints by more than 2); the clip's rotations are taken as they are"});
    double most = 0.05;
    int longest = -1;
    for (const Bone& bone : s.bones) {
        if (!isLong(s, bone)) continue;
        const double by = std::abs(length(bone.of_rig) / (length(bone.of_clip) * s.rig_size / s.clip_size) - 1);
        if (by > most) longest = bone.child;
        most = std::max(most, by);
    }
    if (longest >= 0 && relation != Relation::kNoRest)
        notes.push_back({file, s.name(longest), "other proportions",
                         "the bone before it differs by " + std::to_string(std::lround(100 * most)) +
                             "%; the rig keeps its lengths"});
}

}  // namespace penumbra
