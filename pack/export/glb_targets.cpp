#include "pack/export/glb_targets.h"

#include <array>
#include <map>
#include <set>
#include <utility>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

using GlbTree = nlohmann::ordered_json;

constexpr const char* kMark = "penumbra_export";

// Gives the nodes of the targets meshes of their own where other nodes have the same.
std::size_t splitMeshes(GlbTree& document, std::vector<GlbTarget>& targets) {
    std::map<std::size_t, std::set<std::size_t>> drawing, users;  // nodes that take part, and all, of each mesh
    for (const GlbTarget& target : targets) drawing[target.mesh].insert(target.node);
    GlbTree& nodes = document["nodes"];
    for (std::size_t n = 0; n < nodes.size(); ++n)
        if (nodes[n].contains("mesh")) users[nodes[n].at("mesh").get<std::size_t>()].insert(n);
    std::map<std::size_t, std::size_t> mesh_of_node;
    for (const auto& [mesh, of_mesh] : drawing) {
        // The first node keeps the mesh, unless a node that gets no values has it, too.
        bool keeps = users[mesh] == of_mesh;
        for (const std::size_t node : of_mesh) {
            if (std::exchange(keeps, false)) continue;
            GlbTree copy = document["meshes"].at(mesh);
            mesh_of_node[node] = document["meshes"].size();
            nodes.at(node)["mesh"] = document["meshes"].size();
            document["meshes"].push_back(std::move(copy));
        }
    }
    for (GlbTarget& target : targets)
        if (const auto own = mesh_of_node.find(target.node); own != mesh_of_node.end()) target.mesh = own->second;
    return mesh_of_node.size();
}

}  // namespace

std::vector<GlbTarget> findTargets(const Rig& rig, const ExportRows& rows, GrowingGlb& glb) {
    std::vector<GlbTarget> targets;
    bool instanced = false;
    for (const std::size_t part : rows.parts) {
        const GltfPlace& place = rig.part_colors[part].gltf;
        if (place.node < 0) throw Unsupported(glb.path.string() + ": exports into a file need a .glb or .gltf");
        const auto node = std::size_t(place.node), primitive = std::size_t(place.primitive);
        if (!targets.empty() && targets.back().node == node && targets.back().primitive == primitive) {
            targets.back().parts.push_back(part);
            instanced = true;
            continue;
        }
        const auto mesh = glb.document.at("nodes").at(node).at("mesh").get<std::size_t>();
        targets.push_back({node, mesh, primitive, {part}});
    }
    if (instanced)
        glb.notes.push_back(glb.path.string() +
                            ": instances of EXT_mesh_gpu_instancing share one mesh, which gets the mean "
                            "of their occlusion");
    if (const std::size_t split = splitMeshes(glb.document, targets); split > 0)
        glb.notes.push_back(glb.path.string() + ": several nodes draw one mesh, and " + std::to_string(split) +
                            " of them got a mesh of their own, because the occlusion is another on each");
    return targets;
}

GlbTree& primitiveOf(GrowingGlb& glb, const GlbTarget& target) {
    return glb.document.at("meshes").at(target.mesh).at("primitives").at(target.primitive);
}

void markExport(GrowingGlb& glb, GlbTree mark) {
    // Extras that are no object are somebody else's and stay; then those of the whole file have the mark.
    const std::array<GlbTree*, 2> places{&glb.document.at("asset"), &glb.document};
    for (GlbTree* place : places)
        if (place->contains("extras") && (*place)["extras"].is_object() && (*place)["extras"].contains(kMark))
            throw InvalidInput(glb.path.string() + ": is an export already (asset.extras." + kMark +
                               "); export into the file that it was made of");
    for (GlbTree* place : places)
        if (!place->contains("extras") || (*place)["extras"].is_object()) {
            (*place)["extras"][kMark] = std::move(mark);
            return;
        }
}

}  // namespace penumbra
