#pragma once
// Options about the character that a file holds. All defaults stand here.
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace penumbra {

// Which sides of a surface have shading points of their own: those of the file's materials, or the fronts alone.
enum class RigSides : std::uint8_t { kOfMaterials, kFronts };

struct RigOptions {
    // Globs of nodes. A node brings the meshes of all nodes below it. `nodes` empty: all that the file shows.
    std::vector<std::string> nodes = {}, without = {};
    double split_angle = 20;            // degrees between normals of one place that still make one shading point
    std::optional<double> crease = {};  // degrees between triangles that make an edge where the file has no normals
    RigSides sides = RigSides::kOfMaterials;
    bool strict = false;          // a note (RigNote) is an error
    bool keep_converted = false;  // Rig::converted is wanted
};

// Adds those options that are not the default to the options of a stage.
void listRigOptions(const RigOptions& options, nlohmann::ordered_json& json);

}  // namespace penumbra
