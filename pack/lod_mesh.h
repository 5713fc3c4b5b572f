#pragma once
// Reads a level of detail: another mesh of the skeleton that a model was fitted to.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/drawn_mesh.h"
#include "formats/stage/model_file.h"

namespace penumbra {

struct LodMesh {
    DrawnMesh drawn;
    double rms_distance = 0, max_distance = 0;  // distances of its vertices from the fitted surface, in diagonals of
                                                // that surface
    double turned_share = 0;  // share of its vertices at which no normal of the fitted surface agrees within 90 degrees
    std::vector<std::filesystem::path> files_read;
    std::vector<std::string> notes;  // notes of its reader, one line each
};

// `file` is a rig. `node` is a name or glob of a node of it, whose meshes are the level; "": all that it shows. Joints
// are matched by name, and the rest pose of the level may be bound elsewhere. Throws the errors of readRig(),
// Unsupported for a deforming model and for morph targets that it does not know, and InvalidInput, which names the
// file, where joints are missing, where its rest pose is not that of the model, and where more than one vertex in a
// hundred lies farther than 0.02 diagonals from the fitted surface or looks the other way.
LodMesh readLod(const Model& fitted, const std::filesystem::path& file, const std::string& node, int threads);

}  // namespace penumbra
