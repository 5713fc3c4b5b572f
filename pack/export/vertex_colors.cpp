// The colours that the vertices of a .glb have before an export multiplies them.
#include <algorithm>

#include "formats/common/errors.h"
#include "formats/rig/own_color.h"
#include "pack/export/export_files.h"

namespace penumbra {

namespace {

using GlbTree = nlohmann::ordered_json;

std::size_t vertexCountOf(const ExportedGlb& out, const GlbTarget& target) {
    return out.rig.part_colors[target.parts[0]].vertices;
}

GltfArray readColors(const ExportedGlb& out, const GlbTree& accessor, std::size_t vertices) {
    GltfArray colors = out.numbers.read(accessor.get<std::size_t>(), "COLOR_0");
    if ((colors.components != 3 && colors.components != 4) || colors.count() != vertices)
        throw InvalidInput(out.glb.path.string() + ": COLOR_0 does not have 3 or 4 numbers for each vertex");
    return colors;
}

// Returns the colours with as many numbers a vertex. An alpha that they do not have is `alpha`.
std::vector<float> withComponents(const GltfArray& colors, std::size_t components, float alpha) {
    std::vector<float> out;
    for (std::size_t v = 0; v < colors.count(); ++v)
        for (std::size_t c = 0; c < components; ++c)
            out.push_back(c < colors.components ? float(colors.values[v * colors.components + c]) : alpha);
    return out;
}

}  // namespace

VertexColors ownColors(ExportedGlb& out, const GlbTarget& target, int components) {
    const GlbTree& attributes = primitiveOf(out.glb, target).at("attributes");
    const std::size_t vertices = vertexCountOf(out, target);
    if (!attributes.contains("COLOR_0"))
        return {components, std::vector<float>(vertices * std::size_t(components), 1.0f)};
    const GltfArray own = readColors(out, attributes["COLOR_0"], vertices);
    const std::size_t most = std::max(own.components, std::size_t(components));
    return {int(most), withComponents(own, most, 1)};
}

std::vector<ColorMorph> ownColorMorphs(ExportedGlb& out, const GlbTarget& target, int components) {
    std::vector<ColorMorph> found;
    const GlbTree morphs = primitiveOf(out.glb, target).value("targets", GlbTree::array());
    for (std::size_t m = 0; m < morphs.size(); ++m)
        if (morphs[m].contains("COLOR_0")) {
            const GltfArray own = readColors(out, morphs[m]["COLOR_0"], vertexCountOf(out, target));
            found.push_back({m, withComponents(own, std::size_t(components), 0)});
        }
    return found;
}

void multiplyColors(std::span<float> colors, int components, std::span<const Vec3> factor) {
    for (std::size_t v = 0; v < factor.size(); ++v)
        for (int c = 0; c < 3; ++c) colors[v * std::size_t(components) + std::size_t(c)] *= factor[v][c];
}

void writeColors(ExportedGlb& out, const GlbTarget& target, const VertexColors& colors) {
    const std::size_t accessor = addAccessor(out.glb, colors.values, colors.components, AccessorUse::kVertices);
    GlbTree& primitive = primitiveOf(out.glb, target);
    const bool has_own = primitive.at("attributes").contains("COLOR_0");
    if (primitive.contains("extras") && !primitive["extras"].is_object()) {
        out.glb.notes.push_back(out.glb.path.string() +
                                ": the extras of a primitive are not an object and stay as they are, so that Penumbra "
                                "takes the occlusion for colours when it reads the result");
    } else {
        primitive["extras"][kColorMark] = kMarkOfOcclusion;
        if (has_own) primitive["attributes"][kOwnColor] = GlbTree(primitive["attributes"]["COLOR_0"]);
    }
    primitive["attributes"]["COLOR_0"] = accessor;
}

}  // namespace penumbra
