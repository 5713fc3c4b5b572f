// Takes clips of other files: finds the joints that they move, and moves their keys to the rig's rest pose.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/rig_axes.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_names.h"
#include "formats/rig/rig_retarget.h"

namespace penumbra {

namespace {

constexpr std::size_t kNamesInList = 6;

// Returns "'a', 'b' and 3 more".
std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kNamesInList); ++i)
        text += (i == 0 ? "'" : ", '") + names[i] + "'";
    if (names.size() > kNamesInList) text += " and " + std::to_string(names.size() - kNamesInList) + " more";
    return text;
}

std::vector<int> movedNodes(const RigSource& source) {
    std::set<int> nodes;
    for (const Clip& clip : source.clips)
        for (const Channel& channel : clip.channels) nodes.insert(channel.node);
    return {nodes.begin(), nodes.end()};
}

std::vector<bool> jointNodes(const RigSource& source) {
    std::vector<bool> joints(source.nodes.size());
    for (const SourceSkin& skin : source.skins)
        for (const int n : skin.nodes) joints[std::size_t(n)] = true;
    return joints;
}

std::vector<std::string> namesOf(const RigSource& source, const std::vector<int>& nodes) {
    std::vector<std::string> names;
    for (const int n : nodes) names.push_back(source.nodes[std::size_t(n)].name);
    return names;
}

// Matches nodes of both files by their names, and enters them into `clip_of`.
void matchNodes(const RigSource& rig, const std::vector<int>& targets, const RigSource& from,
                const std::vector<int>& sources, std::vector<int>& clip_of) {
    const std::vector<int> match = matchNames(namesOf(rig, targets), namesOf(from, sources));
    for (std::size_t i = 0; i < targets.size(); ++i)
        if (match[i] >= 0) clip_of[std::size_t(targets[i])] = sources[std::size_t(match[i])];
}

// Finds the node of `from` that moves each node of the rig. Joints come first: all of one name move alike, whatever
// skeleton they are in. What moves no joint may move other nodes.
std::vector<int> findMovers(const RigSource& rig, const RigSource& from, const std::vector<int>& moved) {
    const std::vector<bool> is_joint = jointNodes(rig);
    std::vector<int> joints, others, left, clip_of(rig.nodes.size(), -1);
    for (std::size_t n = 0; n < rig.nodes.size(); ++n) (is_joint[n] ? joints : others).push_back(int(n));
    matchNodes(rig, joints, from, moved, clip_of);
    for (const int n : moved)
        if (std::find(clip_of.begin(), clip_of.end(), n) == clip_of.end()) left.push_back(n);
    matchNodes(rig, others, from, left, clip_of);
    return clip_of;
}

// Tells what moves nothing, what nothing moves, and which names are not the same. Throws where less than half matches.
void checkMatch(RigSource& rig, const RigSource& from, const std::vector<int>& moved, const std::vector<int>& clip_of) {
    std::vector<std::string> lost, still, joints, renamed;
    const std::set<int> used(clip_of.begin(), clip_of.end());
    for (const int n : moved)
        if (!used.contains(n)) lost.push_back(from.nodes[std::size_t(n)].name);
    const std::vector<bool> is_joint = jointNodes(rig);
    std::set<std::pair<int, std::string>> said;
    for (std::size_t n = 0; n < clip_of.size(); ++n) {
        const std::string& name = rig.nodes[n].name;
        if (is_joint[n]) joints.push_back(name);
        if (is_joint[n] && clip_of[n] < 0) still.push_back(name);
        if (clip_of[n] < 0) continue;
        const std::string& of_clip = from.nodes[std::size_t(clip_of[n])].name;
        if (of_clip != name && said.emplace(clip_of[n], name).second) renamed.push_back(of_clip + "' moves '" + name);
    }
    const bool whole_rig = 4 * still.size() <= joints.size() && still.size() < joints.size();
    if (lost.size() == moved.size() || (2 * lost.size() > moved.size() && !whole_rig))
        failAtFile(from.file, std::to_string(lost.size()) + " of the " + std::to_string(moved.size()) +
                                  " nodes that its clips move are not in " + rig.file.string() + ": " + listed(lost) +
                                  (joints.empty() ? "" : "; the joints there are " + listed(joints)));
    const std::string file = from.file.string();
    if (!renamed.empty()) rig.notes.push_back({file, "", "names without their prefixes", listed(renamed)});
    if (!lost.empty())
        rig.notes.push_back({file, "", "channels of " + listed(lost), "move nothing, as the rig has no such node"});
    if (!still.empty()) rig.notes.push_back({file, "", "joints without a channel", listed(still) + " stay as at rest"});
}

// Finds the node of the rig that has the morph targets of each node whose weights the clips of `from` move.
std::map<std::string, int> morphedNodes(const RigSource& rig, const RigSource& from) {
    std::set<int> with_targets, moved;
    for (const SourcePart& part : rig.parts)
        if (!part.targets.empty()) with_targets.insert(part.node);
    for (const MorphChannel& channel : from.morphs) moved.insert(channel.node);
    const std::vector<int> targets(with_targets.begin(), with_targets.end()), sources(moved.begin(), moved.end());
    std::vector<int> clip_of(rig.nodes.size(), -1);
    matchNodes(rig, targets, from, sources, clip_of);
    std::map<std::string, int> node_of_name;
    for (const int n : targets)
        if (clip_of[std::size_t(n)] >= 0)
            node_of_name.emplace(from.nodes[std::size_t(clip_of[std::size_t(n)])].name, n);
    return node_of_name;
}

void takeClip(RigSource& rig, const RigSource& from, std::size_t c, const std::vector<int>& clip_of,
              const Retarget& retarget, const std::map<std::string, int>& morphed) {
    const Clip& clip = from.clips[c];
    Clip taken{clip.name, clip.duration, {}};
    for (const Channel& channel : clip.channels)
        for (std::size_t n = 0; n < clip_of.size(); ++n)
            if (clip_of[n] == channel.node) taken.channels.push_back(retarget.channelOf(channel, int(n)));
    const bool morphs = addWeightChannels(from, int(c), morphed, rig);
    if (taken.channels.empty() && !morphs) {
        rig.notes.push_back({from.file.string(), "", "clip '" + clip.name + "'", "moves no node of the rig, left out"});
        return;
    }
    rig.clips.push_back(std::move(taken));
}

}  // namespace

void makeAnimatable(RigSource& source, int n, const std::string& by) {
    constexpr double kShear = 1e-4;  // relative to the largest column; exporters write six digits
    Node& node = source.nodes[std::size_t(n)];
    if (!node.matrix) return;
    const Matrix m = restTransform(node);
    const Decomposition parts = decompose(m);
    const Matrix again = composeTransform(parts.translation, parts.rotation, parts.scale);
    const double largest = std::max({std::abs(parts.scale[0]), std::abs(parts.scale[1]), std::abs(parts.scale[2])});
    for (const std::size_t i : {0, 1, 2, 4, 5, 6, 8, 9, 10})
        if (!(std::abs(again[i] - m[i]) <= kShear * largest))
            failAtNode(source, n, "has a matrix with shear and cannot be animated by " + by);
    node.translation = parts.translation;
    node.rotation = parts.rotation;
    node.scale = parts.scale;
    node.matrix.reset();
}

void addClips(RigSource& rig, RigSource&& from) {
    if (from.clips.empty())
        throw InvalidInput(from.file.string() + ": brings no clip, and only the first rig brings a mesh");
    const std::vector<int> moved = movedNodes(from);
    const std::vector<int> clip_of = findMovers(rig, from, moved);
    if (!moved.empty() || from.morphs.empty()) checkMatch(rig, from, moved, clip_of);
    for (std::size_t n = 0; n < clip_of.size(); ++n)
        if (clip_of[n] >= 0) makeAnimatable(rig, int(n), from.file.string());
    if (from.axes == SourceAxes::kUnstated) turnToRig(rig, from, clip_of);
    const Retarget retarget(rig, from, clip_of);
    const std::map<std::string, int> morphed = morphedNodes(rig, from);
    for (std::size_t c = 0; c < from.clips.size(); ++c) takeClip(rig, from, c, clip_of, retarget, morphed);
    rig.files_read.insert(rig.files_read.end(), from.files_read.begin(), from.files_read.end());
}

}  // namespace penumbra
