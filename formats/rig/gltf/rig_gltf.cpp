// Converts a glTF scene to a RigSource.
#include "formats/rig/gltf/rig_gltf.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {
struct Importer {
    GltfFile file;
    RigSource source;
    std::vector<int> node_of_file_node;  // glTF's node index to ours
    std::size_t target_vertices = 0;

    [[noreturn]] void fail(const std::string& problem) const { failAtFile(file.path, problem); }
};

std::string nodeName(const tinygltf::Model& model, std::size_t node) {
    return model.nodes[node].name.empty() ? "node" + std::to_string(node) : cleanText(model.nodes[node].name);
}

std::vector<int> fileParents(const Importer& importer) {
    const tinygltf::Model& model = importer.file.model;
    std::vector<int> parents(model.nodes.size(), -1);
    for (std::size_t n = 0; n < model.nodes.size(); ++n)
        for (const int child : model.nodes[n].children) {
            const std::string where = "node '" + nodeName(model, n) + "'";
            if (child < 0 || std::size_t(child) >= parents.size()) importer.fail(where + ": a child does not exist");
            if (parents[std::size_t(child)] >= 0 || std::size_t(child) == n)
                importer.fail(where + ": its child '" + nodeName(model, std::size_t(child)) + "' has two parents");
            parents[std::size_t(child)] = int(n);
        }
    return parents;
}

template <std::size_t N>
void copyNumbers(const Importer& importer, std::size_t node, const char* field, const std::vector<double>& from,
                 std::array<double, N>& to) {
    if (from.empty()) return;
    const std::string where = "node '" + nodeName(importer.file.model, node) + "': ";
    if (from.size() != N) importer.fail(where + field + " has " + std::to_string(from.size()) + " numbers");
    for (const double v : from)
        if (!std::isfinite(v) || std::abs(v) > 1e30) importer.fail(where + field + " is not finite");
    std::copy(from.begin(), from.end(), to.begin());
}

Node convertNode(const Importer& importer, std::size_t index) {
    const tinygltf::Node& from = importer.file.model.nodes[index];
    Node node;
    node.name = nodeName(importer.file.model, index);
    copyNumbers(importer, index, "translation", from.translation, node.translation);
    copyNumbers(importer, index, "rotation", from.rotation, node.rotation);
    copyNumbers(importer, index, "scale", from.scale, node.scale);
    const auto unit = normalized(node.rotation);
    if (!unit) importer.fail("node '" + node.name + "': rotation is a quaternion of length 0");
    node.rotation = *unit;
    if (!from.matrix.empty()) {
        std::array<double, 16> matrix;
        copyNumbers(importer, index, "matrix", from.matrix, matrix);
        if (matrix[3] != 0 || matrix[7] != 0 || matrix[11] != 0 || matrix[15] != 1)
            importer.fail("node '" + node.name + "': matrix is not affine");
        node.matrix = matrix;
    }
    return node;
}

// Converts nodes depth first, from the roots in file order, so that parents come before children.
void convertNodes(Importer& importer) {
    const std::vector<int> parents = fileParents(importer);
    const std::vector<tinygltf::Node>& nodes = importer.file.model.nodes;
    importer.node_of_file_node.assign(nodes.size(), -1);
    std::vector<int> stack;
    for (std::size_t n = nodes.size(); n-- > 0;)
        if (parents[n] < 0) stack.push_back(int(n));
    while (!stack.empty()) {
        const std::size_t n = std::size_t(stack.back());
        stack.pop_back();
        importer.node_of_file_node[n] = int(importer.source.nodes.size());
        importer.source.nodes.push_back(convertNode(importer, n));
        if (parents[n] >= 0) importer.source.nodes.back().parent = importer.node_of_file_node[std::size_t(parents[n])];
        stack.insert(stack.end(), nodes[n].children.rbegin(), nodes[n].children.rend());
    }
    for (std::size_t n = 0; n < nodes.size(); ++n)
        if (importer.node_of_file_node[n] < 0)
            importer.fail("node '" + nodeName(importer.file.model, n) + "' is its own ancestor");
}

void convertSkins(Importer& importer) {
    const tinygltf::Model& model = importer.file.model;
    for (std::size_t s = 0; s < model.skins.size(); ++s) {
        const tinygltf::Skin& from = model.skins[s];
        const std::string where = "skin " + std::to_string(s) + (from.name.empty() ? "" : " '" + from.name + "'");
        SourceSkin skin;
        for (const int joint : from.joints) {
            if (joint < 0 || std::size_t(joint) >= model.nodes.size())
                importer.fail(where + ": names node " + std::to_string(joint) + ", which does not exist");
            skin.nodes.push_back(importer.node_of_file_node[std::size_t(joint)]);
        }
        if (skin.nodes.empty()) importer.fail(where + ": has no joints");
        skin.inverse_bind.assign(skin.nodes.size(), kIdentityMatrix);
        if (from.inverseBindMatrices >= 0) {
            const AccessorValues m =
                readAccessor(importer.file, from.inverseBindMatrices, where + " inverse bind matrices");
            if (m.components != 16 || m.count() < skin.nodes.size())
                importer.fail(where + ": has fewer inverse bind matrices than joints");
            for (std::size_t j = 0; j < skin.nodes.size(); ++j)
                for (std::size_t r = 0; r < 3; ++r)
                    for (std::size_t c = 0; c < 4; ++c) skin.inverse_bind[j][4 * r + c] = m.values[16 * j + 4 * c + r];
        }
        importer.source.skins.push_back(std::move(skin));
    }
}

std::string materialName(const GltfFile& file, int material) {
    if (material < 0 || std::size_t(material) >= file.materials.size()) return kDefaultSlot;
    const std::string& name = file.materials[std::size_t(material)].name;
    return name.empty() ? "material" + std::to_string(material) : name;
}

// Refuses more vertices of targets than memory should hold.
void countTargets(Importer& importer, const SourcePart& part) {
    for (const std::vector<Vec3>& target : part.targets) importer.target_vertices += target.size();
    if (importer.target_vertices > kMaxTargetVertices)
        throw Unsupported(importer.file.path.string() + ": its morph targets are too large");
}

// Notes what a material shows that we do not.
void noteEffects(Importer& importer, const tinygltf::Primitive& primitive, int our_node) {
    if (primitive.material < 0 || std::size_t(primitive.material) >= importer.file.materials.size()) return;
    const std::string name = "material '" + materialName(importer.file, primitive.material) + "': ";
    for (const GltfEffect& effect : importer.file.materials[std::size_t(primitive.material)].effects)
        importer.source.notes.push_back({importer.file.path.string(), importer.source.nodes[std::size_t(our_node)].name,
                                         effect.feature, name + effect.effect});
}

void convertPrimitive(Importer& importer, const tinygltf::Node& node, int our_node,
                      const tinygltf::Primitive& primitive, const std::string& where) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) importer.fail(where + ": has no POSITION");
    AccessorValues values = readAccessor(importer.file, position->second, where + " POSITION");
    if (values.components != 3) importer.fail(where + ": POSITION does not have 3 numbers for a vertex");
    SourcePart part;
    part.node = our_node;
    part.skin = node.skin;
    part.material = materialName(importer.file, primitive.material);
    part.positions.reserve(values.count());
    for (std::size_t v = 0; v < values.count(); ++v)
        part.positions.push_back(toFloat({values.values[3 * v], values.values[3 * v + 1], values.values[3 * v + 2]}));
    values = {};
    readNormals(importer.file, primitive, where, importer.source, part);
    part.triangles = readTriangles(importer.file, primitive, part.positions.size(), where);
    readPartColor(importer.file, primitive, where, part);
    noteEffects(importer, primitive, our_node);
    if (node.skin >= 0) readInfluences(importer.file, primitive, where, part);
    readMorphTargets(importer.file, node, primitive, where, part);
    noteTargets(primitive, importer.file.path, importer.source.nodes[std::size_t(our_node)].name,
                importer.source.notes);
    countTargets(importer, part);
    importer.source.parts.push_back(std::move(part));
}

// Returns where the node's mesh stands in the node's space. A mesh with a skin stands where its bones are.
std::vector<Matrix> placesOf(Importer& importer, std::size_t n, const std::string& where) {
    const std::vector<Matrix> instances = instancesOf(importer.file, n, where);
    if (importer.file.model.nodes[n].skin < 0 || !importer.file.node_extensions[n].instanced) return instances;
    importer.source.notes.push_back({importer.file.path.string(), nodeName(importer.file.model, n),
                                     "EXT_mesh_gpu_instancing",
                                     "a mesh with a skin is drawn once, where its bones are"});
    return {kIdentityMatrix};
}

// Puts copies of the last part where the instances stand. The last instance takes the part itself, because a scan would
// not fit twice.
void copyToInstances(const std::vector<Matrix>& instances, std::vector<SourcePart>& parts) {
    SourcePart part = std::move(parts.back());
    parts.pop_back();
    for (std::size_t i = 0; i + 1 < instances.size(); ++i) parts.push_back(movedPart(part, instances[i]));
    if (!instances.empty()) parts.push_back(movedPart(std::move(part), instances.back()));
}

void convertMeshes(Importer& importer) {
    const tinygltf::Model& model = importer.file.model;
    const std::vector<Drawn> drawn = drawnNodes(importer.file);
    std::size_t vertices = 0;
    for (std::size_t n = 0; n < model.nodes.size(); ++n) {
        const tinygltf::Node& node = model.nodes[n];
        if (node.mesh < 0 || drawn[n] == Drawn::kNo) continue;
        const std::string where = "node '" + nodeName(model, n) + "'";
        if (std::size_t(node.mesh) >= model.meshes.size()) importer.fail(where + ": its mesh does not exist");
        if (node.skin >= 0 && std::size_t(node.skin) >= model.skins.size())
            importer.fail(where + ": its skin does not exist");
        const std::vector<Matrix> instances = placesOf(importer, n, where);
        const std::vector<tinygltf::Primitive>& primitives = model.meshes[std::size_t(node.mesh)].primitives;
        for (const tinygltf::Primitive& primitive : primitives) {
            if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
                importer.source.notes.push_back({importer.file.path.string(), nodeName(model, n), "points or lines",
                                                 "they are not drawn, and cast no shadow"});
                continue;
            }
            if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
                importer.fail(where + ": has a primitive of an unknown mode");
            convertPrimitive(importer, node, importer.node_of_file_node[n], primitive, where);
            importer.source.parts.back().gltf = {int(n), int(&primitive - primitives.data())};
            importer.source.parts.back().visible = drawn[n] == Drawn::kYes ? Visible::kShown : Visible::kHidden;
            vertices += instances.size() * importer.source.parts.back().positions.size();
            if (vertices > kMaxSourceVertices)
                throw Unsupported(importer.file.path.string() + ": has too many vertices");
            copyToInstances(instances, importer.source.parts);
        }
    }
}

// Viewers show one scene, and so do we; a character that stands in another one would be missed.
void noteScenes(Importer& importer) {
    const tinygltf::Model& model = importer.file.model;
    const std::vector<Drawn> drawn = drawnNodes(importer.file);
    for (const tinygltf::Scene& scene : model.scenes) {
        const auto isLeftOut = [&](int n) {
            return n >= 0 && std::size_t(n) < drawn.size() && drawn[std::size_t(n)] == Drawn::kNo;
        };
        if (std::ranges::any_of(scene.nodes, isLeftOut))
            importer.source.notes.push_back({importer.file.path.string(), "", "scene '" + cleanText(scene.name) + "'",
                                             "is not the file's default scene, and left out"});
    }
}

Interpolation interpolationOf(const Importer& importer, const std::string& name, const std::string& where) {
    if (name == "LINEAR" || name.empty()) return Interpolation::kLinear;
    if (name == "STEP") return Interpolation::kStep;
    if (name == "CUBICSPLINE") return Interpolation::kCubicSpline;
    importer.fail(where + ": unknown interpolation '" + name + "'");
}

struct Sampler {
    Interpolation interpolation = Interpolation::kLinear;
    std::vector<double> times;
    AccessorValues values;
};

Sampler readSampler(const Importer& importer, const tinygltf::Animation& clip, int index, const std::string& where) {
    if (index < 0 || std::size_t(index) >= clip.samplers.size()) importer.fail(where + ": has no sampler");
    const tinygltf::AnimationSampler& from = clip.samplers[std::size_t(index)];
    Sampler sampler;
    sampler.interpolation = interpolationOf(importer, from.interpolation, where);
    const AccessorValues times = readAccessor(importer.file, from.input, where + " times");
    if (times.components != 1) importer.fail(where + ": times are not scalars");
    sampler.times = times.values;
    sampler.values = readAccessor(importer.file, from.output, where + " values");
    for (std::size_t i = 1; i < sampler.times.size(); ++i)
        if (!(sampler.times[i] >= sampler.times[i - 1]))
            importer.fail(where + ": key times do not ascend at key " + std::to_string(i));
    return sampler;
}

// Checks that a sampler has elements of `components` numbers, `elements` of them for each key.
void checkSize(const Importer& importer, const Sampler& sampler, int components, std::size_t elements,
               const std::string& where) {
    const std::size_t values_a_key = (sampler.interpolation == Interpolation::kCubicSpline ? 3 : 1) * elements;
    if (sampler.values.components != components || sampler.values.count() != values_a_key * sampler.times.size())
        importer.fail(where + ": the numbers of times and values do not fit");
}

void checkRotations(const Importer& importer, const Channel& channel, const std::string& where) {
    if (channel.path != Channel::Path::kRotation || channel.interpolation == Interpolation::kCubicSpline) return;
    for (std::size_t i = 0; i < channel.values.size(); i += 4)
        if (!normalized({channel.values[i], channel.values[i + 1], channel.values[i + 2], channel.values[i + 3]}))
            importer.fail(where + ": key " + std::to_string(i / 4) + " is a quaternion of length 0");
}

Channel convertChannel(Importer& importer, const tinygltf::Animation& clip, const tinygltf::AnimationChannel& from,
                       const std::string& where) {
    Channel channel;
    channel.node = importer.node_of_file_node[std::size_t(from.target_node)];
    makeAnimatable(importer.source, channel.node, "clip '" + cleanText(clip.name) + "'");
    const bool rotation = from.target_path == "rotation";
    if (from.target_path == "scale")
        channel.path = Channel::Path::kScale;
    else if (rotation)
        channel.path = Channel::Path::kRotation;
    else if (from.target_path != "translation")
        importer.fail(where + ": is not a property that can be animated");
    Sampler sampler = readSampler(importer, clip, from.sampler, where);
    checkSize(importer, sampler, rotation ? 4 : 3, 1, where);
    channel.interpolation = sampler.interpolation;
    channel.times = std::move(sampler.times);
    channel.values.assign(sampler.values.values.begin(), sampler.values.values.end());
    checkRotations(importer, channel, where);
    return channel;
}

// Converts morph weights of a node whose mesh is drawn and has morph targets.
void convertWeights(Importer& importer, const tinygltf::Animation& clip, const tinygltf::AnimationChannel& from,
                    const std::string& where, MorphChannel channel) {
    const auto drawn = [&](const SourcePart& part) { return part.node == channel.node && !part.targets.empty(); };
    const auto part = std::find_if(importer.source.parts.begin(), importer.source.parts.end(), drawn);
    if (part == importer.source.parts.end()) {
        importer.source.notes.push_back({importer.file.path.string(),
                                         importer.source.nodes[std::size_t(channel.node)].name, "morph weights",
                                         "a clip drives them, but the node draws no mesh with morph targets"});
        return;
    }
    Sampler sampler = readSampler(importer, clip, from.sampler, where);
    checkSize(importer, sampler, 1, part->targets.size(), where);
    channel.interpolation = sampler.interpolation;
    channel.times = std::move(sampler.times);
    channel.values.assign(sampler.values.values.begin(), sampler.values.values.end());
    importer.source.morphs.push_back(std::move(channel));
}

// Converts clips. It passes over channels without a node. A clip without any other channel is left out.
void convertClips(Importer& importer) {
    const tinygltf::Model& model = importer.file.model;
    for (std::size_t a = 0; a < model.animations.size(); ++a) {
        const tinygltf::Animation& from = model.animations[a];
        Clip clip;
        clip.name = from.name.empty() ? "clip" + std::to_string(a) : cleanText(from.name);
        clip.gltf_animation = int(a);
        if (from.channels.empty())
            importer.source.notes.push_back(
                {importer.file.path.string(), "", "clip '" + clip.name + "'", "has no channel, left out"});
        const std::size_t morphs = importer.source.morphs.size();
        for (const tinygltf::AnimationChannel& channel : from.channels) {
            if (channel.target_node < 0) continue;
            if (std::size_t(channel.target_node) >= model.nodes.size())
                importer.fail("clip '" + clip.name + "': a node does not exist");
            const std::string where = "clip '" + clip.name + "': node '" +
                                      nodeName(model, std::size_t(channel.target_node)) + "' " + channel.target_path;
            if (channel.target_path != "weights") {
                clip.channels.push_back(convertChannel(importer, from, channel, where));
                clip.duration = std::max(clip.duration, clip.channels.back().times.back());
            } else {
                MorphChannel weights;
                weights.clip = int(importer.source.clips.size());
                weights.node = importer.node_of_file_node[std::size_t(channel.target_node)];
                convertWeights(importer, from, channel, where, std::move(weights));
            }
        }
        for (std::size_t m = morphs; m < importer.source.morphs.size(); ++m)
            clip.duration = std::max(clip.duration, importer.source.morphs[m].times.back());
        if (!clip.channels.empty() || importer.source.morphs.size() > morphs)
            importer.source.clips.push_back(std::move(clip));
    }
}

}  // namespace

RigSource readGltf(const std::filesystem::path& path) {
    Importer importer{.file = openGltf(path), .source = {}, .node_of_file_node = {}};
    importer.source.file = path;
    importer.source.files_read = importer.file.files_read;
    importer.source.notes = std::move(importer.file.notes);
    noteExtensions(importer.file, importer.source.notes);
    convertNodes(importer);
    convertSkins(importer);
    convertMeshes(importer);
    noteScenes(importer);
    convertClips(importer);
    tidyClips(importer.source);
    return std::move(importer.source);
}

}  // namespace penumbra
