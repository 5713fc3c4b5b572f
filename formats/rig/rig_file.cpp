#include "formats/rig/rig_file.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "formats/common/errors.h"
#include "formats/rig/frame_sampling.h"
#include "formats/rig/rig_normals.h"

namespace penumbra {

namespace {

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

void turnMirroredNormals(Rig& rig) {
    const std::vector<bool> mirrored = mirroredAtRest(rig);
    for (std::size_t v = 0; v < rig.rest_normals.size(); ++v)
        if (mirrored[v]) rig.rest_normals[v] = -rig.rest_normals[v];
    MorphTargets& morphs = rig.mesh.morphs;
    for (std::size_t i = 0; i < morphs.vertices.size(); ++i)
        if (mirrored[morphs.vertices[i]]) morphs.normals[i] = -morphs.normals[i];
}

// Creases are for meshes without normals: where all vertices have some, asking for them does nothing.
void noteCreases(const SourceVertices& vertices, const RigOptions& options, RigSource& source) {
    const auto isSet = [](const Vec3& normal) { return dot(normal, normal) > 0; };
    if (options.crease && !vertices.normals.empty() && std::ranges::all_of(vertices.normals, isSet))
        source.notes.push_back({source.file.string(), "", "creases", "the file has normals, which stand as they are"});
}

Rig buildRig(RigSource& source, const RigOptions& options) {
    std::size_t triangles = 0;
    for (const SourcePart& part : source.parts) triangles += part.triangles.size();
    if (triangles == 0) {
        const char* advice = source.clips.empty() ? "" : " (a file of clips stands behind the rig that has the mesh)";
        throw InvalidInput(source.file.string() + ": has no triangles" + advice);
    }
    sayInfluences(source);
    const JointTable table = chooseJoints(source);
    Rig rig;
    SourceVertices vertices = gatherVertices(source, table);
    for (SourcePart& part : source.parts) {  // gathered, and of a scan the most by far
        giveBack(part.positions);
        giveBack(part.normals);
        giveBack(part.triangles);
        giveBack(part.joints);
        giveBack(part.weights);
    }
    const double diagonal = characterDiagonal(vertices.triangles, vertices.positions);
    if (!std::isfinite(diagonal) || !(diagonal > 0))
        throw InvalidInput(source.file.string() + ": its vertices are all at one place, or not finite");
    noteCreases(vertices, options, source);
    WeldedPoints welded = weldVertices(vertices, options, rig.mesh, rig.skin);
    noteAgainstWinding(vertices, welded.against_winding, source);
    rig.part_colors = std::move(vertices.part_colors);
    if (rig.mesh.triangles.empty()) throw InvalidInput(source.file.string() + ": has no triangle with an area");
    rig.source_corners = std::move(welded.source_corners);
    rig.rest_normals = std::move(welded.rest_normals);
    setMorphs(vertices.morphs, {welded.first_of_place, welded.vertex_of_point}, rig.rest_normals, rig.mesh);
    rig.weight_curves = weightCurves(source, vertices.morphs);
    if (options.sides == RigSides::kOfMaterials) addBacks(rig);
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
    const std::vector<Affine> at_rest = evaluatePose(rig, -1, 0).bones;  // throws where a transform is not finite
    turnMirroredNormals(rig);
    RestShape shape;
    skinMorphed(rig.mesh, rig.skin, rig.rest_normals, {at_rest, rig.mesh.morphs.rest_weights}, shape);
    noteTwins(source, rig, shape.positions);
    return rig;
}

}  // namespace

Rig joinRig(std::vector<RigSource> sources, const RigOptions& options) {
    assert(!sources.empty());
    RigSource& first = sources.front();
    bool had_converter = false;  // it stands last, once
    for (RigSource& source : sources)
        if (source.converted && std::exchange(had_converter, true)) source.files_read.pop_back();
    dropIdleClips(first);
    for (RigSource& source : sources) trimLateClips(source);
    for (std::size_t i = 1; i < sources.size(); ++i) {
        for (Clip& clip : sources[i].clips) clip.gltf_animation = -1;
        addClips(first, std::move(sources[i]));
    }
    selectParts(first, options);
    makeClipNamesUnique(first.clips);
    if (first.clips.size() > 65535) throw Unsupported(first.file.string() + ": more than 65535 clips");
    const std::shared_ptr<const std::vector<std::byte>> converted = first.converted;
    Rig rig = buildRig(first, options);
    if (options.keep_converted) rig.converted = converted;
    rig.notes = takeNotes(sources);
    for (const RigSource& source : sources) rig.log.insert(rig.log.end(), source.log.begin(), source.log.end());
    if (options.strict) refuseNotes(rig.notes);
    return rig;
}

std::vector<bool> mirroredAtRest(const Rig& rig) {
    const std::vector<Affine> bones = evaluatePose(rig, -1, 0).bones;
    const std::size_t k = std::size_t(rig.skin.influences);
    std::vector<bool> mirrored;
    for (std::size_t v = 0; v < rig.mesh.vertexCount(); ++v) {
        const Affine blend = blendBones(std::span(rig.skin.joints).subspan(v * k, k),
                                        std::span(rig.skin.weights).subspan(v * k, k), bones);
        mirrored.push_back(determinant(blend.linear()) < 0);
    }
    return mirrored;
}

namespace {

ClipTimes timesOf(const Rig& rig, std::size_t index) {
    const Clip& clip = rig.clips[index];
    ClipTimes times{clip.name, 0, clip.duration, {}};
    for (const WeightCurve& curve : rig.weight_curves)
        if (std::size_t(curve.clip) == index)
            times.keys.insert(times.keys.end(), curve.times.begin(), curve.times.end());
    for (const Channel& channel : clip.channels)
        times.keys.insert(times.keys.end(), channel.times.begin(), channel.times.end());
    std::sort(times.keys.begin(), times.keys.end());
    return times;
}

}  // namespace

FrameList sampleFrames(const Rig& rig, const std::vector<std::string>& clips, double fps) {
    std::vector<ClipTimes> times;
    for (std::size_t c = 0; c < rig.clips.size(); ++c) times.push_back(timesOf(rig, c));
    const FrameList frames = sampleClips(times, clips, fps, "the rig");
    return frames.frameCount() > 0 ? frames : FrameList{{kRestClip}, {0}, {0.0}};
}

}  // namespace penumbra
