#include "formats/rig/rig_file.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "formats/common/errors.h"
#include "formats/rig/frame_sampling.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

// Maps names to nodes. Skinned nodes win over others of the same name, and of several the first wins.
std::map<std::string, int> nodesByName(const RigSource& source) {
    std::map<std::string, int> node_of_name;
    for (const SourceSkin& skin : source.skins)
        for (const int n : skin.nodes) node_of_name.emplace(source.nodes[std::size_t(n)].name, n);
    for (std::size_t n = 0; n < source.nodes.size(); ++n) node_of_name.emplace(source.nodes[n].name, int(n));
    return node_of_name;
}

// Moves the clips of `from` to `rig`, and leaves out channels of nodes that `rig` does not have.
void addClips(RigSource& rig, RigSource&& from) {
    if (from.clips.empty())
        throw InvalidInput(from.file.string() + ": brings no clip, and only the first rig brings a mesh");
    const std::map<std::string, int> node_of_name = nodesByName(rig);
    for (Clip& clip : from.clips) {
        std::vector<Channel> channels;
        for (Channel& channel : clip.channels) {
            const auto node = node_of_name.find(from.nodes[std::size_t(channel.node)].name);
            if (node == node_of_name.end()) continue;
            channel.node = node->second;
            if (rig.nodes[std::size_t(channel.node)].matrix)
                failAtNode(rig, channel.node, "has a matrix and cannot be animated by " + from.file.string());
            channels.push_back(std::move(channel));
        }
        if (channels.empty())
            throw InvalidInput(from.file.string() + ": clip '" + clip.name + "' moves no node of " + rig.file.string());
        clip.channels = std::move(channels);
        rig.clips.push_back(std::move(clip));
    }
    rig.files_read.insert(rig.files_read.end(), from.files_read.begin(), from.files_read.end());
}

void makeClipNamesUnique(std::vector<Clip>& clips) {
    std::vector<std::string> names;
    names.reserve(clips.size());
    for (const Clip& clip : clips) names.push_back(clip.name);
    names = uniqueNames(std::move(names));
    for (std::size_t i = 0; i < clips.size(); ++i) clips[i].name = names[i];
}

// Returns for each joint the nearest ancestor that is a joint. Joints that share a node share that ancestor.
std::vector<std::int32_t> jointParents(const std::vector<Node>& nodes, const std::vector<int>& node_of_joint) {
    std::vector<std::int32_t> joint_of_node(nodes.size(), -1);
    for (std::size_t j = node_of_joint.size(); j-- > 0;) joint_of_node[std::size_t(node_of_joint[j])] = std::int32_t(j);
    std::vector<std::int32_t> parents;
    for (const int node : node_of_joint) {
        int ancestor = nodes[std::size_t(node)].parent;
        while (ancestor >= 0 && joint_of_node[std::size_t(ancestor)] < 0)
            ancestor = nodes[std::size_t(ancestor)].parent;
        parents.push_back(ancestor < 0 ? -1 : joint_of_node[std::size_t(ancestor)]);
    }
    return parents;
}

Affine toAffine(const Matrix& matrix) {
    Affine affine;
    std::copy(matrix.begin(), matrix.end(), affine.m.begin());
    return affine;
}

void setRestTransforms(Rig& rig) {
    const std::vector<Matrix> globals = restGlobals(rig.nodes);
    Skin& skin = rig.skin;
    for (std::size_t j = 0; j < skin.jointCount(); ++j) {
        Matrix rest = globals[std::size_t(rig.node_of_joint[j])];
        if (skin.parents[j] >= 0) {
            const int parent = rig.node_of_joint[std::size_t(skin.parents[j])];
            const std::optional<Matrix> from_scene = inverse(globals[std::size_t(parent)]);
            if (!from_scene) {
                skin.rest_transforms.clear();
                skin.inverse_bind.clear();
                return;
            }
            rest = multiply(*from_scene, rest);
        }
        skin.rest_transforms.push_back(toAffine(rest));
        skin.inverse_bind.push_back(toAffine(rig.inverse_bind[j]));
    }
}

Rig buildRig(RigSource&& source) {
    std::size_t triangles = 0;
    for (const SourcePart& part : source.parts) triangles += part.triangles.size();
    if (triangles == 0) throw InvalidInput(source.file.string() + ": has no triangles");
    const JointTable table = chooseJoints(source);
    Rig rig;
    SourceVertices vertices = gatherVertices(source, table);
    for (SourcePart& part : source.parts) {  // gathered, and of a scan the most by far
        part.positions = {};
        part.triangles = {};
        part.joints = {};
        part.weights = {};
    }
    const double diagonal = boxDiagonal(vertices.positions);
    if (!std::isfinite(diagonal) || !(diagonal > 0))
        throw InvalidInput(source.file.string() + ": its vertices are all at one place, or not finite");
    weldVertices(vertices, rig.mesh, rig.skin);
    rig.part_colors = std::move(vertices.part_colors);
    if (rig.mesh.triangles.empty()) throw InvalidInput(source.file.string() + ": has no triangle with an area");
    rig.rest_normals = vertexNormals(rig.mesh.triangles, rig.mesh.rest_positions);
    rig.nodes = std::move(source.nodes);
    rig.node_of_joint = table.nodes;
    rig.inverse_bind = table.inverse_bind;
    std::vector<std::string> names;
    for (const int node : rig.node_of_joint) names.push_back(rig.nodes[std::size_t(node)].name);
    rig.skin.joint_names = uniqueNames(std::move(names));
    rig.skin.parents = jointParents(rig.nodes, rig.node_of_joint);
    setRestTransforms(rig);
    rig.clips = std::move(source.clips);
    rig.files_read = std::move(source.files_read);
    evaluatePose(rig, -1, 0);  // throws where a transform is not finite
    return rig;
}

}  // namespace

Rig joinRig(std::vector<RigSource> sources, const RigOptions& options) {
    assert(!sources.empty());
    RigSource& first = sources.front();
    for (std::size_t i = 1; i < sources.size(); ++i) addClips(first, std::move(sources[i]));
    makeClipNamesUnique(first.clips);
    if (first.clips.size() > 65535) throw Unsupported(first.file.string() + ": more than 65535 clips");
    Rig rig = buildRig(std::move(first));
    rig.notes = takeNotes(sources);
    if (options.strict) refuseNotes(rig.notes);
    return rig;
}

namespace {

ClipTimes timesOf(const Clip& clip) {
    ClipTimes times{clip.name, 0, clip.duration, {}};
    for (const Channel& channel : clip.channels)
        times.keys.insert(times.keys.end(), channel.times.begin(), channel.times.end());
    std::sort(times.keys.begin(), times.keys.end());
    return times;
}

}  // namespace

FrameList sampleFrames(const Rig& rig, const std::vector<std::string>& clips, double fps) {
    std::vector<ClipTimes> times;
    for (const Clip& clip : rig.clips) times.push_back(timesOf(clip));
    const FrameList frames = sampleClips(times, clips, fps, "the rig");
    return frames.frameCount() > 0 ? frames : FrameList{{kRestClip}, {0}, {0.0}};
}

}  // namespace penumbra
