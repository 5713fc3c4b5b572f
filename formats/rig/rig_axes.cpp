// Finds the axes of motion capture.
//
// Problem: BVH does not state which axis is up. Most files have y up, but programs whose own axis is z (Blender's
// exporter among them) write z. Such a file is the same skeleton, lying down.
//
// Here: the rig knows its own axes, so the rest poses decide. Of the 24 turns that take axes to axes, the one is taken
// under which all long bones point as they do in the rig. Where several fit, as for a chain of bones on one line,
// nothing is turned: then the comparison of the rest poses takes the file as it stands, or refuses it.
//
// All nodes of a BVH stand upright at rest. So a turn T of the whole file takes a place p to T p, and a rotation about
// the axis a to one about T a by the same angle.
#include "formats/rig/rig_axes.h"

#include <array>
#include <string>

#include "formats/rig/rig_skeletons.h"

namespace penumbra {

namespace {

// Component i of a turned vector is sign[i] times component axis[i] of what it was.
struct AxisTurn {
    std::array<std::size_t, 3> axis{0, 1, 2};
    std::array<int, 3> sign{1, 1, 1};

    bool operator==(const AxisTurn&) const = default;
};

template <class Numbers>
void turn(const AxisTurn& by, Numbers&& v) {
    const std::array old{v[0], v[1], v[2]};
    for (std::size_t i = 0; i < 3; ++i) v[i] = by.sign[i] < 0 ? -old[by.axis[i]] : old[by.axis[i]];
}

Vec3d turned(const AxisTurn& by, Vec3d v) {
    std::array<double, 3> numbers{v.x, v.y, v.z};
    turn(by, numbers);
    return {numbers[0], numbers[1], numbers[2]};
}

// Returns the turns without mirrors; the first one changes nothing.
std::vector<AxisTurn> allTurns() {
    std::vector<AxisTurn> turns;
    for (const std::array<std::size_t, 3>& axis :
         std::array<std::array<std::size_t, 3>, 6>{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}})
        for (int signs = 0; signs < 8; ++signs) {
            const AxisTurn t{axis, {signs & 4 ? -1 : 1, signs & 2 ? -1 : 1, signs & 1 ? -1 : 1}};
            const Vec3d x = turned(t, {1, 0, 0}), y = turned(t, {0, 1, 0}), z = turned(t, {0, 0, 1});
            if (dot(cross(x, y), z) > 0) turns.push_back(t);
        }
    return turns;
}

// Returns the turn that the bones ask for, or the one that changes nothing.
AxisTurn turnOfBones(const Skeletons& s) {
    std::vector<AxisTurn> fitting;
    for (const AxisTurn& t : allTurns())
        if (longBonesAgree(s, [&](Vec3d of_clip) { return turned(t, of_clip); })) fitting.push_back(t);
    const bool is_clear = fitting.size() == 1 && fitting[0] != AxisTurn{};
    return is_clear ? fitting[0] : AxisTurn{};
}

std::string axesOf(const AxisTurn& t) {
    std::string text;
    for (std::size_t i = 0; i < 3; ++i)
        text += std::string(i == 0 ? "" : ", ") + (t.sign[i] < 0 ? "-" : "+") + "xyz"[t.axis[i]];
    return text;
}

}  // namespace

void turnToRig(RigSource& rig, RigSource& from, const std::vector<int>& clip_of) {
    const AxisTurn by = turnOfBones(skeletonsOf(rig, from, clip_of));
    if (by == AxisTurn{}) return;
    for (Node& node : from.nodes) turn(by, node.translation);
    for (Clip& clip : from.clips)
        for (Channel& channel : clip.channels) {
            const std::size_t width = channel.path == Channel::Path::kRotation ? 4 : 3;
            for (std::size_t at = 0; at + width <= channel.values.size(); at += width) turn(by, &channel.values[at]);
        }
    rig.notes.push_back({from.file.string(), "", "other axes",
                         "its bones tell them: the rig's x, y and z are its " + axesOf(by) + ", and it is turned so"});
}

}  // namespace penumbra
