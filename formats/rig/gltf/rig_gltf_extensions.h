#pragma once
// Extensions of glTF that change which triangles a scene has, or what moves them: KHR_node_visibility, MSFT_lod,
// EXT_mesh_gpu_instancing and KHR_animation_pointer.
#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "formats/rig/rig_build.h"

namespace penumbra {

// The extensions of one node that Penumbra reads.
struct GltfNodeExtensions {
    bool hidden = false;            // KHR_node_visibility: with all nodes below it
    std::vector<int> lower_levels;  // MSFT_lod: nodes that show the same with fewer triangles
    bool instanced = false;         // EXT_mesh_gpu_instancing
    // Accessors of one translation, rotation and scale for each instance; -1: none
    std::array<int, 3> instance_accessors{-1, -1, -1};
};

// Returns one for each node of the document. Throws InvalidInput where a field has another type.
std::vector<GltfNodeExtensions> readNodeExtensions(const std::filesystem::path& path, const nlohmann::json& document);

// Gives the channels of KHR_animation_pointer that move a node (translation, rotation, scale, weights) the node and the
// path of a plain channel. All other channels with a pointer are taken out, with a note for each property.
std::vector<RigNote> resolvePointers(const std::filesystem::path& path, nlohmann::json& document);

// Notes the extensions of a file that are not read and may change what it shows.
struct GltfFile;
void noteExtensions(const GltfFile& file, std::vector<RigNote>& notes);

enum class Drawn : std::uint8_t { kNo, kHidden, kYes };
// Returns for each node whether the scene that the file shows has it: that of "scene", or else the first one, or else
// all nodes. Lower levels of detail and invisible nodes are hidden, with all that is below them.
std::vector<Drawn> drawnNodes(const GltfFile& file);

// Returns the transforms of the instances of a node's mesh to the node; one identity where the node has none of its
// own. `where` names the node in messages. Throws InvalidInput.
std::vector<Matrix> instancesOf(const GltfFile& file, std::size_t node, const std::string& where);
// Returns the part moved by an instance's transform.
SourcePart movedPart(SourcePart part, const Matrix& to_node);

}  // namespace penumbra
