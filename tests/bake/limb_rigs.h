#pragma once
// The synthetic man, and joints that a test adds to him.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>

#include "bake/poses/limbs.h"
#include "formats/source/source_readers.h"

namespace penumbra::samples {

inline Rig sampleRig(const std::string& name) {
    return readRig({std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / name});
}

inline std::size_t jointNamed(const Rig& rig, const std::string& name) {
    const auto& names = rig.skin.joint_names;
    return std::size_t(std::find(names.begin(), names.end(), name) - names.begin());
}

// Adds a node under `parent`, which is a joint as well. At rest it stands at `to_parent`, and it takes over the
// vertices of which `takes` says so.
inline std::size_t addJoint(Rig& rig, const std::string& name, int parent, const Matrix& to_parent,
                            const std::function<bool(Vec3)>& takes) {
    const Decomposition parts = decompose(to_parent);
    Node node;
    node.name = name;
    node.parent = parent;
    node.translation = parts.translation;
    node.rotation = parts.rotation;
    node.scale = parts.scale;
    rig.nodes.push_back(node);
    const auto joint = std::uint16_t(rig.node_of_joint.size());
    const auto above = std::find(rig.node_of_joint.begin(), rig.node_of_joint.end(), parent);
    rig.skin.parents.push_back(parent < 0 ? -1 : std::int32_t(above - rig.node_of_joint.begin()));
    rig.skin.joint_names.push_back(name);
    rig.node_of_joint.push_back(int(rig.nodes.size()) - 1);
    rig.inverse_bind.push_back(*inverse(restGlobals(rig.nodes).back()));
    const auto influences = std::size_t(rig.skin.influences);
    for (std::size_t v = 0; v < rig.mesh.vertexCount(); ++v) {
        if (!takes(rig.mesh.rest_positions[v])) continue;
        for (std::size_t k = 0; k < influences; ++k) {
            rig.skin.joints[v * influences + k] = k == 0 ? joint : std::uint16_t(0);
            rig.skin.weights[v * influences + k] = k == 0 ? 1.0f : 0.0f;
        }
    }
    return joint;
}

}  // namespace penumbra::samples
