#pragma once
// Nodes that a file of assimp only names. Its bones and clips know nodes by name, and names need not be unique: a mesh
// and a bone may both be called "head", and two characters have the same joints.
#include <map>
#include <string>

#include "formats/rig/rig_build.h"

namespace penumbra {

using NamedNodes = std::multimap<std::string, int>;  // in the order of the nodes where names are equal

struct NamedBone {
    std::string name;
    Matrix inverse_bind;
    int mesh_node = 0;
};

// Returns the node of a bone, or -1 where no node has its name. Of several it is the one that stands where the mesh was
// bound: its rest transform times the inverse bind matrix is the transform of the mesh. Throws Unsupported where that
// is not clear.
int nodeOfBone(const RigSource& source, const NamedNodes& nodes, const NamedBone& bone);

// Returns the node that a channel moves, or -1 where no node has this name. Of several it is the only bone, which is
// said. Throws Unsupported where more than one is a bone, or none. `skins` of the source must be read.
int nodeOfChannel(RigSource& source, const NamedNodes& nodes, const std::string& name);

}  // namespace penumbra
