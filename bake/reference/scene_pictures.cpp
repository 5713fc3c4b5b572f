#include "bake/reference/scene_pictures.h"

namespace penumbra {

namespace {

// Triangles are fronts alone, as in the scene's mesh.
MeshSurface meshSurfaceOf(const AssetView& asset) {
    const SurfaceView& surface = *asset.surface;
    MeshSurface out;
    const std::vector<std::uint32_t> drawn =
        surface.drawnTriangles(asset.mesh.frontTriangles(), asset.mesh.positions.size());
    for (std::size_t set = 0; set < surface.uv_sets; ++set) {
        std::vector<Uv> uv;
        uv.reserve(drawn.size());
        for (const std::uint32_t corner : drawn) uv.push_back(surface.uvOf(set)[corner]);
        out.uv.push_back(std::move(uv));
    }
    for (const std::uint32_t corner : drawn)
        if (!surface.colors.empty()) out.colors.push_back(surface.colors[corner]);
    for (const std::uint32_t corner : drawn)
        if (!surface.turns.empty()) out.turns.push_back(surface.turns[corner]);
    out.slots.assign(surface.slots.begin(), surface.slots.end());
    for (const TextureView& texture : surface.textures)
        out.textures.push_back({std::string(texture.name), std::string(texture.file),
                                std::vector<std::byte>(texture.bytes.begin(), texture.bytes.end())});
    return out;
}

std::vector<std::uint16_t> slotsOfTriangles(const MeshView& mesh) {
    std::vector<std::uint16_t> slots;
    const auto corners = mesh.frontTriangles();
    for (std::size_t t = 0; t < corners.size(); t += 3)
        slots.push_back(mesh.slot_of_vertex.empty() ? std::uint16_t(0) : mesh.slot_of_vertex[corners[t]]);
    return slots;
}

}  // namespace

std::vector<bool> picturedSlots(const AssetView& asset, const std::vector<std::size_t>& material_of_slot) {
    std::vector<bool> pictured(material_of_slot.size(), asset.surface.has_value());
    for (std::size_t s = 0; s < pictured.size() && asset.surface; ++s)
        pictured[s] = material_of_slot[s] == (asset.slot_material.empty() ? 0 : asset.slot_material[s]);
    return pictured;
}

std::shared_ptr<const PictureSurface> ScenePictures::surfaceOf(const SceneCharacter& one, const AssetView& asset,
                                                               const std::vector<bool>& pictured) {
    std::shared_ptr<const PictureSurface>& known = opened_[{&asset, pictured}];
    if (known) return known;
    auto surface = std::make_shared<PictureSurface>(meshSurfaceOf(asset), slotsOfTriangles(asset.mesh),
                                                    one.asset.parent_path(), one.asset.string());
    for (std::size_t s = 0; s < pictured.size(); ++s)
        if (!pictured[s]) surface->leaveOut(s);
    return known = std::move(surface);
}

}  // namespace penumbra
