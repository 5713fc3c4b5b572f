// Reads morph targets of glTF (glTF 2.0, section 3.7.2.2).
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

// Returns what a target adds to an attribute of every vertex, or nothing where it does not have the attribute.
std::vector<Vec3> readTarget(const GltfFile& file, const std::map<std::string, int>& attributes,
                             const std::string& attribute, const std::string& what, std::size_t vertices) {
    std::vector<Vec3> out;
    const auto found = attributes.find(attribute);
    if (found == attributes.end()) return out;
    const AccessorValues values = readAccessor(file, found->second, what);
    if (values.components != 3 || values.count() != vertices)
        failAtFile(file.path, what + ": does not have 3 numbers for every vertex");
    for (std::size_t v = 0; v < vertices; ++v)
        out.push_back(toFloat({values.values[3 * v], values.values[3 * v + 1], values.values[3 * v + 2]}));
    return out;
}

// Reads the names that exporters put into the extras of the mesh, or of its primitives.
std::vector<std::string> namesOf(const tinygltf::Value& extras) {
    std::vector<std::string> names;
    if (!extras.IsObject() || !extras.Has("targetNames")) return names;
    const tinygltf::Value& list = extras.Get("targetNames");
    for (std::size_t i = 0; list.IsArray() && i < list.ArrayLen(); ++i) {
        const tinygltf::Value& name = list.Get(int(i));
        names.push_back(name.IsString() ? cleanText(name.Get<std::string>()) : "");
    }
    return names;
}

}  // namespace

void readMorphTargets(const GltfFile& file, const tinygltf::Node& node, const tinygltf::Primitive& primitive,
                      const std::string& where, SourcePart& part) {
    const std::size_t vertices = part.positions.size(), targets = primitive.targets.size();
    part.mesh = node.mesh;
    if (targets == 0) return;
    const tinygltf::Mesh& mesh = file.model.meshes[std::size_t(node.mesh)];
    const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
    if (!weights.empty() && weights.size() != targets)
        failAtFile(file.path, where + ": has " + std::to_string(weights.size()) + " weights for " +
                                  std::to_string(targets) + " morph targets");
    part.rest_weights = weights.empty() ? std::vector<double>(targets) : weights;
    part.target_names = namesOf(mesh.extras);
    if (part.target_names.empty()) part.target_names = namesOf(primitive.extras);
    for (std::size_t t = 0; t < targets; ++t) {
        const std::string what = where + " morph target " + std::to_string(t);
        part.targets.push_back(readTarget(file, primitive.targets[t], "POSITION", what, vertices));
        part.target_normals.push_back(readTarget(file, primitive.targets[t], "NORMAL", what + " NORMAL", vertices));
    }
}

void noteTargets(const tinygltf::Primitive& primitive, const std::filesystem::path& file, const std::string& node,
                 std::vector<RigNote>& notes) {
    std::set<std::string> others;
    for (const auto& target : primitive.targets)
        for (const auto& [attribute, accessor] : target)
            if (attribute.starts_with("COLOR_") || attribute.starts_with("TEXCOORD_")) others.insert(attribute);
    for (const std::string& attribute : others)
        notes.push_back({file.string(), node, "morph targets of " + attribute, "it stays as it is at rest"});
}

}  // namespace penumbra
