#include "pack/sections/surface_section.h"

#include <map>

#include "formats/common/write_file.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

// Where a corner lies in the pictures, its colour, and its turned tangent.
struct Place {
    std::array<Uv, kMaxUvSets> uv{};
    VertexColor color = kWhiteVertex;
    TangentTurn turn = kSameTangent;
    auto operator<=>(const Place&) const = default;
};

// The vertices that are drawn: the mesh's own, which take the place of their first corner, and copies.
struct DrawnVertices {
    std::vector<std::uint32_t> seam_vertices, seam_corners, seam_of_corner;
    std::vector<Uv> uv;               // [sets, V + E]
    std::vector<VertexColor> colors;  // [V + E], or empty
    std::vector<TangentTurn> turns;   // [V + E], or empty
};

DrawnVertices numberVertices(const MeshSurface& surface, std::span<const Triangle> triangles, std::size_t vertices) {
    const std::size_t sets = surface.uv.size();
    DrawnVertices out;
    std::vector<Place> places(vertices, Place{});
    std::vector<bool> known(vertices, false);
    std::map<std::pair<std::uint32_t, Place>, std::uint32_t> copies;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = triangles[t][k];
            Place place;
            for (std::size_t s = 0; s < sets; ++s) place.uv[s] = surface.uv[s][3 * t + k];
            if (!surface.colors.empty()) place.color = surface.colors[3 * t + k];
            if (!surface.turns.empty()) place.turn = surface.turns[3 * t + k];
            if (!known[vertex]) places[vertex] = place, known[vertex] = true;
            if (places[vertex] == place) continue;
            const auto [at, is_new] = copies.try_emplace({vertex, place}, std::uint32_t(out.seam_vertices.size()));
            if (is_new) out.seam_vertices.push_back(vertex), places.push_back(place);
            out.seam_corners.push_back(std::uint32_t(3 * t + k));
            out.seam_of_corner.push_back(at->second);
        }
    for (std::size_t s = 0; s < sets; ++s)
        for (const Place& place : places) out.uv.push_back(place.uv[s]);
    for (const Place& place : places)
        if (!surface.colors.empty()) out.colors.push_back(place.color);
    for (const Place& place : places)
        if (!surface.turns.empty()) out.turns.push_back(place.turn);
    return out;
}

fbs::SlotSurface storedSlot(SlotSurface slot, std::size_t first_material) {
    const auto shift = [&](std::uint16_t& material) { material = std::uint16_t(material + first_material); };
    shift(slot.materials.diffuse);
    for (std::size_t s = 0; s < slot.materials.steps; ++s) shift(slot.materials.f0[s]), shift(slot.materials.f90[s]);
    fbs::SlotSurface out;
    static_assert(sizeof out == sizeof slot);  // asset_checks_surface.cpp compares the fields
    std::memcpy(static_cast<void*>(&out), &slot, sizeof out);
    return out;
}

Offset<fbs::Texture> writeTexture(FlatBufferBuilder& builder, const SurfaceTexture& texture) {
    const auto name = builder.CreateString(texture.name);
    if (!texture.file.empty()) return fbs::CreateTexture(builder, name, builder.CreateString(texture.file.string()));
    return fbs::CreateTexture(builder, name, {}, writeVector<std::uint8_t>(builder, texture.bytes));
}

}  // namespace

void storeTextures(TextureStorage storage, const fs::path& folder, MeshSurface& surface) {
    for (SurfaceTexture& texture : surface.textures) {
        if (storage == TextureStorage::kEmbed)
            texture.file.clear();
        else if (!texture.file.empty())
            texture.file = fs::relative(texture.file, folder.empty() ? fs::path(".") : folder);
    }
}

Offset<fbs::Surface> writeSurface(FlatBufferBuilder& builder, const SurfaceLook& look,
                                  std::span<const Triangle> triangles, std::size_t vertices,
                                  std::size_t first_material) {
    const MeshSurface& surface = look.surface;
    const DrawnVertices drawn = numberVertices(surface, triangles, vertices);
    const auto seam_vertices = writeVector<std::uint32_t>(builder, drawn.seam_vertices);
    const auto seam_corners = writeVector<std::uint32_t>(builder, drawn.seam_corners);
    const auto seam_of_corner = writeVector<std::uint32_t>(builder, drawn.seam_of_corner);
    const auto uv = writeVector<float>(builder, drawn.uv);
    Offset<flatbuffers::Vector<std::uint16_t>> colors;
    if (!drawn.colors.empty()) colors = writeVector<std::uint16_t>(builder, drawn.colors);
    Offset<flatbuffers::Vector<std::int8_t>> turns;
    if (!drawn.turns.empty()) turns = writeVector<std::int8_t>(builder, drawn.turns);
    std::vector<fbs::SlotSurface> stored;
    for (const SlotSurface& slot : surface.slots) stored.push_back(storedSlot(slot, first_material));
    builder.ForceVectorAlignment(stored.size(), sizeof(fbs::SlotSurface), 16);
    const auto slots = builder.CreateVectorOfStructs(stored);
    std::vector<Offset<fbs::Texture>> textures;
    for (const SurfaceTexture& texture : surface.textures) textures.push_back(writeTexture(builder, texture));
    const auto texture_vector = builder.CreateVector(textures);
    return fbs::CreateSurface(builder, seam_vertices, seam_corners, seam_of_corner, std::uint8_t(surface.uv.size()), uv,
                              slots, texture_vector, colors, turns);
}

}  // namespace penumbra
