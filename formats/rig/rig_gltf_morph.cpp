// Reads morph targets of glTF (glTF 2.0, section 3.7.2.2).
#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_gltf.h"

namespace penumbra {

constexpr std::size_t kMaxTargetVertices = std::size_t(1) << 26;  // 800 MB

void readMorphTargets(const GltfFile& file, const tinygltf::Primitive& primitive,
                      const std::vector<double>& default_weights, const std::string& where, std::size_t& total,
                      SourcePart& part) {
    const std::size_t vertices = part.positions.size(), targets = primitive.targets.size();
    if (targets == 0) return;
    if (!default_weights.empty() && default_weights.size() != targets)
        failAtFile(file.path, where + ": has " + std::to_string(default_weights.size()) + " weights for " +
                                  std::to_string(targets) + " morph targets");
    part.rest_weights = default_weights.empty() ? std::vector<double>(targets) : default_weights;
    for (std::size_t t = 0; t < targets; ++t) {
        part.targets.emplace_back();
        const auto position = primitive.targets[t].find("POSITION");
        if (position == primitive.targets[t].end()) continue;
        total += vertices;
        if (total > kMaxTargetVertices) throw Unsupported(file.path.string() + ": its morph targets are too large");
        const std::string what = where + " morph target " + std::to_string(t);
        const AccessorValues values = readAccessor(file, position->second, what);
        if (values.components != 3 || values.count() != vertices)
            failAtFile(file.path, what + ": does not have 3 numbers for every vertex");
        for (std::size_t v = 0; v < vertices; ++v)
            part.targets.back().push_back(
                toFloat({values.values[3 * v], values.values[3 * v + 1], values.values[3 * v + 2]}));
    }
}

}  // namespace penumbra
