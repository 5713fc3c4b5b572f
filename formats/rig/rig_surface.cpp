#include "formats/rig/rig_surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

using PartUv = std::vector<std::array<double, 2>>;

// Gathers textures, each once, and the sets of coordinates of every part. Lists of equal numbers are one set.
struct SurfaceBuilder {
    const Rig& rig;
    const std::string& file;
    RigSurface out = {};
    std::map<const Texture*, std::uint16_t> index_of_texture = {};
    std::vector<std::vector<const PartUv*>> sets_of_part = {};  // [parts][sets]

    TextureUse use(const std::shared_ptr<const Texture>& texture, std::uint8_t wrap, std::uint8_t set) {
        std::vector<SurfaceTexture>& textures = out.surface.textures;
        const auto [at, is_new] = index_of_texture.try_emplace(texture.get(), std::uint16_t(textures.size()));
        if (is_new) textures.push_back({texture->name, texture->file, texture->bytes});
        return {at->second, set, wrap};
    }

    std::uint8_t setOf(std::size_t part, const PartUv& uv, const std::string& where) {
        std::vector<const PartUv*>& sets = sets_of_part[part];
        for (std::size_t s = 0; s < sets.size(); ++s)
            if (*sets[s] == uv) return std::uint8_t(s);
        if (sets.size() == kMaxUvSets)
            throw Unsupported(where + ": its pictures lie in more than " + std::to_string(kMaxUvSets) + " ways");
        sets.push_back(&uv);
        return std::uint8_t(sets.size() - 1);
    }
};

void addSlot(SurfaceBuilder& builder, std::size_t p) {
    const ColoredPart& part = builder.rig.part_colors[p];
    const MaterialColor& material = part.color.material;
    const std::string where = builder.file + ": slot '" + builder.rig.mesh.slots[part.slot] + "'";
    for (const std::string& problem : {material.problem, part.color.textures_problem})
        if (!problem.empty()) builder.out.notes.push_back(problem + kNumbersAlone);
    SlotSurface& slot = builder.out.surface.slots[part.slot];
    slot.base = material.base.value_or(Vec3{1, 1, 1});
    slot.alpha = material.alpha_mode == AlphaMode::kOpaque ? 1 : material.alpha;
    slot.alpha_cutoff = material.alpha_mode == AlphaMode::kMask    ? std::max(material.alpha_cutoff, 0.0f)
                        : material.alpha_mode == AlphaMode::kBlend ? kBlendAlpha
                                                                   : 0;
    if (material.texture)
        slot.use(TextureRole::kBaseColor) = builder.use(material.texture, wrapByte(material.wrap_u, material.wrap_v),
                                                        builder.setOf(p, part.color.uv, where));
    for (const PartTexture& texture : part.color.textures) {
        if (texture.uv.empty()) continue;  // reported by textures_problem
        slot.use(texture.role) =
            builder.use(texture.texture, wrapByte(texture.wrap_u, texture.wrap_v), builder.setOf(p, texture.uv, where));
        if (texture.role == TextureRole::kNormal) slot.normal_scale = texture.strength;
        if (texture.role == TextureRole::kOcclusion) slot.occlusion_strength = std::clamp(texture.strength, 0.0f, 1.0f);
    }
}

// Returns the part of each source vertex.
std::vector<std::uint32_t> partOfVertex(const Rig& rig) {
    std::vector<std::uint32_t> part(rig.mesh.source_vertex.size());
    for (std::uint32_t p = 0; p < rig.part_colors.size(); ++p)
        std::fill_n(part.begin() + std::ptrdiff_t(rig.part_colors[p].first_vertex), rig.part_colors[p].vertices, p);
    return part;
}

VertexColor colorOf(const PartColor& part, std::size_t vertex) {
    const auto stored = [](float x) { return std::uint16_t(std::lround(65535 * std::clamp(x, 0.0f, 1.0f))); };
    VertexColor out = kWhiteVertex;
    for (int c = 0; c < 3 && !part.tints.empty(); ++c) out[std::size_t(c)] = stored(part.tints[vertex][c]);
    if (!part.alphas.empty()) out[3] = stored(part.alphas[vertex]);
    return out;
}

// Lays the coordinates, colours and turned tangents of source vertices on the corners of the mesh's triangles, and of
// their backs.
void setCorners(SurfaceBuilder& builder) {
    const Rig& rig = builder.rig;
    std::size_t sets = 0;
    for (const auto& of_part : builder.sets_of_part) sets = std::max(sets, of_part.size());
    const std::vector<std::uint32_t> part_of_vertex = partOfVertex(rig);
    const bool colored =
        std::ranges::any_of(rig.part_colors, [](const ColoredPart& part) { return !part.color.tints.empty(); });
    if (colored) builder.out.surface.colors.assign(3 * rig.mesh.triangles.size(), kWhiteVertex);
    if (std::ranges::any_of(rig.part_colors, [](const ColoredPart& part) { return !part.color.turns.empty(); }))
        builder.out.surface.turns.assign(3 * rig.mesh.triangles.size(), kSameTangent);
    builder.out.surface.uv.assign(sets, std::vector<Uv>(3 * rig.mesh.triangles.size(), Uv{0, 0}));
    for (std::size_t t = 0; t < rig.source_corners.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = rig.source_corners[t][k], part = part_of_vertex[vertex];
            const std::size_t in_part = vertex - rig.part_colors[part].first_vertex;
            if (colored) builder.out.surface.colors[3 * t + k] = colorOf(rig.part_colors[part].color, in_part);
            if (const std::vector<TangentTurn>& turns = rig.part_colors[part].color.turns; !turns.empty())
                builder.out.surface.turns[3 * t + k] = turns[in_part];
            for (std::size_t s = 0; s < builder.sets_of_part[part].size(); ++s) {
                const std::array<double, 2>& uv = (*builder.sets_of_part[part][s])[in_part];
                builder.out.surface.uv[s][3 * t + k] = {float(uv[0]), float(uv[1])};
            }
        }
}

}  // namespace

RigSurface surfaceOf(const Rig& rig, const std::string& file) {
    SurfaceBuilder builder{rig, file};
    builder.out.surface.slots.resize(std::max<std::size_t>(1, rig.mesh.slots.size()));
    builder.sets_of_part.resize(rig.part_colors.size());
    for (std::size_t p = 0; p < rig.part_colors.size(); ++p) addSlot(builder, p);
    setCorners(builder);
    std::vector<std::string>& notes = builder.out.notes;
    std::sort(notes.begin(), notes.end());
    notes.erase(std::unique(notes.begin(), notes.end()), notes.end());
    return std::move(builder.out);
}

void fitSurface(const Rig& rig, const Mesh& mesh, const std::string& file, MeshSurface& surface) {
    bool same = rig.mesh.slots == mesh.slots && rig.mesh.triangles.size() == mesh.frontTriangleCount();
    for (std::size_t t = 0; same && t < rig.mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            same =
                same && rig.mesh.rest_positions[rig.mesh.triangles[t][k]] == mesh.rest_positions[mesh.triangles[t][k]];
    if (!same)
        throw InvalidInput(file +
                           ": its mesh is not that of the model (was the bake made of other files, of other nodes or "
                           "with creases?)");
    if (!mesh.two_sided) return;
    const auto addBacks = [&](auto& corners) {
        for (std::size_t t = 0; t < rig.mesh.triangles.size(); ++t)
            for (const std::size_t k : {0, 2, 1}) {
                const auto front = corners[3 * t + k];
                corners.push_back(front);
            }
    };
    for (std::vector<Uv>& uv : surface.uv) addBacks(uv);
    if (!surface.colors.empty()) addBacks(surface.colors);
    if (!surface.turns.empty()) addBacks(surface.turns);
}

}  // namespace penumbra
