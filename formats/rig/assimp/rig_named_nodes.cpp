#include "formats/rig/assimp/rig_named_nodes.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

std::vector<int> nodesNamed(const NamedNodes& nodes, const std::string& name) {
    std::vector<int> found;
    const auto [first, last] = nodes.equal_range(name);
    for (auto it = first; it != last; ++it) found.push_back(it->second);
    return found;
}

[[noreturn]] void refuseName(const RigSource& source, const std::string& name, const char* who) {
    throw Unsupported(source.file.string() + ": several nodes are called '" + name +
                      "', and assimp does not tell which of them " + who + "; give them names of their own");
}

Matrix globalOf(const RigSource& source, int node) {
    Matrix m = kIdentityMatrix;
    for (; node >= 0; node = source.nodes[std::size_t(node)].parent)
        m = multiply(restTransform(source.nodes[std::size_t(node)]), m);
    return m;
}

// Returns the largest difference of two transforms, in parts of their own size.
double differenceOf(const Matrix& a, const Matrix& b) {
    double size = 1e-30, difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        size = std::max({size, std::abs(a[i]), std::abs(b[i])});
        difference = std::max(difference, std::abs(a[i] - b[i]));
    }
    return difference / size;
}

// Tells whether a node is a bone, or a link of the chain that assimp makes of an FBX bone (rig_fbx_pivots.cpp).
bool isBone(const RigSource& source, int node) {
    for (const SourceSkin& skin : source.skins)
        if (std::find(skin.nodes.begin(), skin.nodes.end(), node) != skin.nodes.end()) return true;
    if (source.nodes[std::size_t(node)].name.find("_$AssimpFbx$_") == std::string::npos) return false;
    for (std::size_t n = std::size_t(node) + 1; n < source.nodes.size(); ++n)
        if (source.nodes[n].parent == node) return isBone(source, int(n));
    return false;
}

}  // namespace

int nodeOfBone(const RigSource& source, const NamedNodes& nodes, const NamedBone& bone) {
    constexpr double kSamePlace = 1e-3;
    const std::vector<int> named = nodesNamed(nodes, bone.name);
    if (named.empty()) return -1;
    if (named.size() == 1) return named[0];
    const Matrix mesh = globalOf(source, bone.mesh_node);
    std::vector<int> fitting;
    for (const int n : named)
        if (n != bone.mesh_node && differenceOf(multiply(globalOf(source, n), bone.inverse_bind), mesh) < kSamePlace)
            fitting.push_back(n);
    if (fitting.size() != 1) refuseName(source, bone.name, "is the bone of a mesh");
    return fitting[0];
}

int nodeOfChannel(RigSource& source, const NamedNodes& nodes, const std::string& name) {
    const std::vector<int> named = nodesNamed(nodes, name);
    if (named.empty()) return -1;
    if (named.size() == 1) return named[0];
    std::vector<int> bones;
    for (const int n : named)
        if (isBone(source, n)) bones.push_back(n);
    if (bones.size() != 1) refuseName(source, name, "a clip moves");
    source.notes.push_back({source.file.string(), name, "several nodes of this name", "clips move the bone"});
    return bones[0];
}

}  // namespace penumbra
