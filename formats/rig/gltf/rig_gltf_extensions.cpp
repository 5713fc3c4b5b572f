// Reads the extensions of glTF that change which triangles a scene has, or what moves them. They are read from the
// JSON, since tinygltf gets a document without extensions.
#include "formats/rig/gltf/rig_gltf_extensions.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/gltf/rig_gltf.h"

namespace penumbra {

namespace {

using Json = nlohmann::json;

const char* const kVisibility = "KHR_node_visibility";
const char* const kLevels = "MSFT_lod";
const char* const kInstancing = "EXT_mesh_gpu_instancing";
const char* const kPointer = "KHR_animation_pointer";

// Returns an object's member, or an empty object.
const Json& memberOf(const Json& object, const char* key) {
    static const Json kNothing = Json::object();
    const auto found = object.is_object() ? object.find(key) : object.end();
    return object.is_object() && found != object.end() ? *found : kNothing;
}

std::string nameOfNode(const Json& document, std::size_t node) {
    const Json& name = memberOf(memberOf(document, "nodes").at(node), "name");
    return name.is_string() && !name.get<std::string>().empty() ? cleanText(name.get<std::string>())
                                                                : "node" + std::to_string(node);
}

GltfNodeExtensions nodeExtensions(const Json& node) {
    const Json& extensions = memberOf(node, "extensions");
    GltfNodeExtensions out;
    out.hidden = !memberOf(extensions, kVisibility).value("visible", true);
    if (const Json& levels = memberOf(memberOf(extensions, kLevels), "ids"); levels.is_array())
        out.lower_levels = levels.get<std::vector<int>>();
    const Json& attributes = memberOf(memberOf(extensions, kInstancing), "attributes");
    std::size_t i = 0;
    for (const char* name : {"TRANSLATION", "ROTATION", "SCALE"})
        if (int& accessor = out.instance_accessors[i++]; attributes.contains(name)) {
            accessor = attributes.at(name).get<int>();
            out.instanced = true;
        }
    return out;
}

}  // namespace

std::vector<GltfNodeExtensions> readNodeExtensions(const std::filesystem::path& path, const Json& document) {
    std::vector<GltfNodeExtensions> all;
    for (const Json& node : memberOf(document, "nodes")) try {
            all.push_back(nodeExtensions(node));
        } catch (const Json::exception& error) {
            failAtFile(path, "node '" + nameOfNode(document, all.size()) + "': its extensions: " + error.what());
        }
    return all;
}

// --- Pointers -------------------------------------------------------------------------------------------------------

namespace {

struct NodePointer {
    std::size_t node = 0;
    std::string property;
};

// Splits "/nodes/12/rotation". Returns nothing where the pointer is not into a node that exists.
std::optional<NodePointer> nodePointer(const std::string& pointer, std::size_t nodes) {
    const std::string prefix = "/nodes/";
    if (pointer.rfind(prefix, 0) != 0) return std::nullopt;
    NodePointer out;
    const char *first = pointer.data() + prefix.size(), *last = pointer.data() + pointer.size();
    const auto [end, error] = std::from_chars(first, last, out.node);
    if (error != std::errc() || end == first || end == last || *end != '/' || out.node >= nodes) return std::nullopt;
    out.property.assign(end + 1, last);
    return out;
}

// Tells whether such a property, of which nothing is read, could be seen.
std::string effectOf(const std::string& property) {
    if (property.find(kVisibility) != std::string::npos) return "it is shown, or not, as it is without the clip";
    return "it stays as it is without the clip";
}

// Resolves the pointer of a channel's target. Returns a note where nobody reads what it points to.
std::optional<RigNote> resolvePointer(const std::filesystem::path& path, const Json& document, Json& target) {
    const Json& said = memberOf(memberOf(memberOf(target, "extensions"), kPointer), "pointer");
    const std::string pointer = said.is_string() ? said.get<std::string>() : "";
    const auto to = nodePointer(pointer, memberOf(document, "nodes").size());
    if (to)
        for (const char* property : {"translation", "rotation", "scale", "weights"})
            if (to->property == property) {
                target = {{"node", to->node}, {"path", property}};
                return std::nullopt;
            }
    return RigNote{path.string(), to ? nameOfNode(document, to->node) : "",
                   std::string(kPointer) + " to '" + cleanText(pointer) + "'", effectOf(pointer)};
}

}  // namespace

std::vector<RigNote> resolvePointers(const std::filesystem::path& path, Json& document) {
    std::vector<RigNote> notes;
    if (!document.contains("animations") || !document["animations"].is_array()) return notes;
    for (Json& clip : document["animations"]) {
        if (!clip.is_object() || !clip.contains("channels") || !clip["channels"].is_array()) continue;
        Json kept = Json::array();
        for (Json& channel : clip["channels"]) {
            std::optional<RigNote> note;
            if (memberOf(memberOf(channel, "target"), "path") == Json("pointer"))
                note = resolvePointer(path, document, channel["target"]);
            if (note)
                notes.push_back(std::move(*note));
            else
                kept.push_back(std::move(channel));
        }
        clip["channels"] = std::move(kept);
    }
    return notes;
}

// --- What is drawn --------------------------------------------------------------------------------------------------

namespace {

struct Visit {
    int node;
    bool hidden;
};

std::vector<Visit> rootsOf(const GltfFile& file) {
    const tinygltf::Model& model = file.model;
    std::vector<Visit> roots;
    if (!model.scenes.empty()) {
        const std::size_t scene = model.defaultScene < 0 ? 0 : std::size_t(model.defaultScene);
        if (scene >= model.scenes.size())
            failAtFile(file.path, "its scene " + std::to_string(scene) + " does not exist");
        for (const int n : model.scenes[scene].nodes) roots.push_back({n, false});
        return roots;
    }
    std::vector<bool> is_child(model.nodes.size());
    for (const tinygltf::Node& node : model.nodes)
        for (const int child : node.children)
            if (child >= 0 && std::size_t(child) < is_child.size()) is_child[std::size_t(child)] = true;
    for (std::size_t n = 0; n < model.nodes.size(); ++n)
        if (!is_child[n]) roots.push_back({int(n), false});
    return roots;
}

}  // namespace

std::vector<Drawn> drawnNodes(const GltfFile& file) {
    std::vector<Drawn> drawn(file.model.nodes.size(), Drawn::kNo);
    std::set<int> lower;
    for (const GltfNodeExtensions& node : file.node_extensions)
        lower.insert(node.lower_levels.begin(), node.lower_levels.end());
    std::vector<Visit> stack = rootsOf(file);
    while (!stack.empty()) {
        const Visit visit = stack.back();
        stack.pop_back();
        if (visit.node < 0 || std::size_t(visit.node) >= drawn.size())
            failAtFile(file.path, "its scene names a node that does not exist");
        const std::size_t n = std::size_t(visit.node);
        if (drawn[n] != Drawn::kNo) continue;
        const GltfNodeExtensions& extensions = file.node_extensions[n];
        const bool hidden = visit.hidden || extensions.hidden || lower.contains(visit.node);
        drawn[n] = hidden ? Drawn::kHidden : Drawn::kYes;
        for (const int child : file.model.nodes[n].children) stack.push_back({child, hidden});
        for (const int level : extensions.lower_levels) stack.push_back({level, true});
    }
    return drawn;
}

// --- Instances ------------------------------------------------------------------------------------------------------

namespace {

constexpr std::size_t kMaxInstances = std::size_t(1) << 20;

// Puts the numbers of one accessor, one row for each instance, into `of_property`.
void readRows(const GltfFile& file, int accessor, int components, const std::string& where,
              std::vector<double>& of_property) {
    if (accessor < 0) return;
    AccessorValues values = readAccessor(file, accessor, where);
    if (values.components != components)
        failAtFile(file.path, where + ": does not have " + std::to_string(components) + " numbers for an instance");
    of_property = std::move(values.values);
}

}  // namespace

std::vector<Matrix> instancesOf(const GltfFile& file, std::size_t node, const std::string& where) {
    const GltfNodeExtensions& extensions = file.node_extensions[node];
    if (!extensions.instanced) return {kIdentityMatrix};
    const std::string what = where + ": " + kInstancing;
    std::array<std::vector<double>, 3> rows;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const int components = i == 1 ? 4 : 3;
        readRows(file, extensions.instance_accessors[i], components, what, rows[i]);
        const std::size_t of_this = rows[i].size() / std::size_t(components);
        if (of_this == 0) continue;
        if (count != 0 && of_this != count) failAtFile(file.path, what + ": its accessors have different lengths");
        count = of_this;
    }
    if (count > kMaxInstances) throw Unsupported(file.path.string() + ": " + what + ": has too many instances");
    std::vector<Matrix> out;
    for (std::size_t k = 0; k < count; ++k) {
        std::array<double, 3> translation{0, 0, 0}, scale{1, 1, 1};
        Quaternion rotation{0, 0, 0, 1};
        if (!rows[0].empty()) std::copy_n(&rows[0][3 * k], 3, translation.begin());
        if (!rows[1].empty()) std::copy_n(&rows[1][4 * k], 4, rotation.begin());
        if (!rows[2].empty()) std::copy_n(&rows[2][3 * k], 3, scale.begin());
        const auto unit = normalized(rotation);
        if (!unit)
            failAtFile(file.path, what + ": the rotation of instance " + std::to_string(k) + " has the length 0");
        out.push_back(composeTransform(translation, *unit, scale));
    }
    return out;
}

namespace {

Vec3d turned(const Matrix& m, Vec3 v) { return transformPoint(m, toDouble(v)) - Vec3d{m[3], m[7], m[11]}; }

}  // namespace

SourcePart movedPart(SourcePart part, const Matrix& to_node) {
    if (to_node == kIdentityMatrix) return part;
    part.instance = multiply(to_node, part.instance);
    const bool mirrored = determinant(to_node) < 0;
    for (Vec3& p : part.positions) p = toFloat(transformPoint(to_node, toDouble(p)));
    for (std::vector<Vec3>& target : part.targets)
        for (Vec3& d : target) d = toFloat(turned(to_node, d));
    const Mat3d linear{
        {to_node[0], to_node[1], to_node[2], to_node[4], to_node[5], to_node[6], to_node[8], to_node[9], to_node[10]}};
    const Mat3d of_normals = cofactor(linear);
    for (Vec3& n : part.normals) n = toFloat(normalized(of_normals * toDouble(n) * (mirrored ? -1.0 : 1.0)));
    // Offsets of normals are turned like normals and keep their length relative to them.
    const double size = std::cbrt(std::abs(determinant(to_node)));
    for (std::vector<Vec3>& target : part.target_normals)
        for (Vec3& d : target)
            d = size > 0 ? toFloat(of_normals * toDouble(d) * ((mirrored ? -1.0 : 1.0) / (size * size))) : Vec3{};
    if (mirrored)
        for (Triangle& t : part.triangles) std::swap(t[1], t[2]);
    return part;
}

namespace {

// Extensions that are read, or that change nothing of shapes and movements. Materials have notes of their own.
bool changesNothing(const std::string& extension) {
    constexpr std::array kBeginnings = {"KHR_materials_",    "KHR_texture_",
                                        "EXT_texture_",      "KHR_mesh_quantization",
                                        "KHR_draco_mesh_",   "EXT_meshopt_",
                                        "KHR_meshopt_",      "KHR_node_visibility",
                                        "KHR_animation_",    "MSFT_lod",
                                        "MSFT_texture",      "MSFT_screencoverage",
                                        "EXT_mesh_gpu_",     "KHR_xmp",
                                        "KHR_techniques_",   "KHR_audio",
                                        "EXT_mesh_features", "EXT_structural_meta",
                                        "VRMC_vrm",          "VRMC_materials_"};
    return std::any_of(kBeginnings.begin(), kBeginnings.end(),
                       [&](const char* beginning) { return extension.starts_with(beginning); });
}

}  // namespace

void noteExtensions(const GltfFile& file, std::vector<RigNote>& notes) {
    for (const std::string& extension :
         std::set<std::string>(file.model.extensionsUsed.begin(), file.model.extensionsUsed.end())) {
        const bool springs = extension == "VRM" || extension == "VRMC_springBone";
        const bool lights = extension.starts_with("KHR_lights_") || extension.starts_with("EXT_lights_");
        if (!changesNothing(extension))
            notes.push_back({file.path.string(), "", cleanText(extension),
                             springs  ? "springs of hair and cloth do not swing: bake clips that have them"
                             : lights ? "its lights are not used: penumbra-fit light makes lights"
                                      : "it is not read; what it draws or moves is left out"});
    }
}

}  // namespace penumbra
