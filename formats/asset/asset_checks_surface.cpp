// Checks the pictures on a mesh. The pictures themselves are opened by those who draw them.
#include <cmath>
#include <cstddef>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/asset/asset_field.h"

namespace penumbra {

namespace {

// The file holds slots as the run time does, so that they are read in place.
static_assert(sizeof(fbs::SlotSurface) == sizeof(SlotSurface) && sizeof(fbs::TextureUse) == sizeof(TextureUse) &&
              offsetof(SlotSurface, f90) == 36 && offsetof(SlotSurface, materials) == 64 &&
              offsetof(SlotSurface, uses) == 92);

void checkSeams(const fbs::Surface& stored, const Field& at, const MeshView& mesh, SurfaceView& surface) {
    surface.seam_vertices = spanOf<std::uint32_t>(stored.seam_vertices(), at / "seam_vertices");
    checkIndices(at / "seam_vertices", surface.seam_vertices, mesh.positions.size());
    surface.seam_corners = spanOf<std::uint32_t>(stored.seam_corners(), at / "seam_corners");
    checkIndices(at / "seam_corners", surface.seam_corners, mesh.triangles.size());
    surface.seam_of_corner = spanOf<std::uint32_t>(stored.seam_of_corner(), at / "seam_of_corner");
    checkCount(at / "seam_of_corner", surface.seam_of_corner, surface.seam_corners.size());
    checkIndices(at / "seam_of_corner", surface.seam_of_corner, surface.seam_vertices.size());
    for (std::size_t s = 0; s < surface.seam_corners.size(); ++s) {
        const Field here = (at / "seam_corners")[s];
        here.require(s == 0 || surface.seam_corners[s - 1] < surface.seam_corners[s], "is not ascending");
        here.require(mesh.triangles[surface.seam_corners[s]] == surface.seam_vertices[surface.seam_of_corner[s]],
                     "has a copy of another vertex");
    }
}

void checkUses(const SlotSurface& slot, const Field& at, const SurfaceView& surface) {
    for (std::size_t role = 0; role < kTextureRoles; ++role) {
        const TextureUse& use = slot.uses[role];
        const Field here = (at / "uses")[role];
        if (!use.any()) continue;
        checkRange(here / "texture", use.texture, 0, std::int64_t(surface.textures.size()) - 1);
        checkRange(here / "uv_set", use.uv_set, 0, std::int64_t(surface.uv_sets) - 1);
        checkRange(here / "wrap", use.wrap, 0, 8);
    }
}

void checkNumbers(const SlotSurface& slot, const Field& at) {
    const auto inRange = [&](const char* name, float value, float least, float most) {
        (at / name).require(value >= least && value <= most, "is out of range");  // also not a number
    };
    constexpr float kMax = 1e6f;
    for (int c = 0; c < 3; ++c) {
        inRange("base", slot.base[c], 0, kMax);
        inRange("emissive", slot.emissive[c], 0, kMax);
        inRange("f0", slot.f0[c], 0, 1);
    }
    inRange("f90", slot.f90, 0, 1);
    inRange("metallic", slot.metallic, 0, 1);
    inRange("roughness", slot.roughness, 0, 1);
    inRange("normal_scale", slot.normal_scale, -kMax, kMax);
    inRange("occlusion_strength", slot.occlusion_strength, 0, 1);
    inRange("alpha", slot.alpha, 0, 1);
    if (slot.alpha_cutoff != kBlendAlpha) inRange("alpha_cutoff", slot.alpha_cutoff, 0, kMax);
}

void checkMaterials(const SurfaceMaterials& used, const Field& at, std::size_t materials) {
    checkRange(at / "diffuse", used.diffuse, 0, std::int64_t(materials) - 1);
    checkRange(at / "steps", used.steps, 0, std::int64_t(kMaxRoughnessSteps));
    for (std::size_t s = 0; s < used.steps; ++s) {
        checkRange((at / "step_f0")[s], used.f0[s], 0, std::int64_t(materials) - 1);
        checkRange((at / "step_f90")[s], used.f90[s], 0, std::int64_t(materials) - 1);
        const float roughness = used.roughness[s], before = s > 0 ? used.roughness[s - 1] : -1;
        (at / "step_roughness")[s].require(roughness > before && roughness >= 0 && roughness <= 1,
                                           "is not ascending from 0 to 1");
    }
}

}  // namespace

std::optional<SurfaceView> surfaceOfAsset(const fbs::Asset& asset, const Field& file, const AssetView& view) {
    if (!asset.surface()) return {};
    const fbs::Surface& stored = *asset.surface();
    const Field at = file / "surface";
    at.require(view.has_model, "is given without a model");
    SurfaceView surface;
    checkSeams(stored, at, view.mesh, surface);
    surface.uv_sets = stored.uv_sets();
    checkRange(at / "uv_sets", std::int64_t(surface.uv_sets), 0, std::int64_t(kMaxUvSets));
    surface.uv = spanOf<Uv>(stored.uv(), at / "uv");
    const std::uint64_t drawn = view.mesh.positions.size() + surface.seam_vertices.size();
    checkCount(at / "uv", surface.uv, surface.uv_sets * drawn);
    checkFinite(at / "uv", surface.uv);
    surface.colors = spanOf<VertexColor>(stored.colors(), at / "colors");
    if (!surface.colors.empty()) checkCount(at / "colors", surface.colors, drawn);
    surface.turns = spanOf<TangentTurn>(stored.turns(), at / "turns");
    if (!surface.turns.empty()) checkCount(at / "turns", surface.turns, drawn);
    if (stored.textures())
        for (const fbs::Texture* texture : *stored.textures()) {
            const Field here = (at / "textures")[surface.textures.size()];
            TextureView& made = surface.textures.emplace_back();
            made.name = textOf(texture->name());
            if (texture->file()) made.file = textOf(texture->file());
            made.bytes = spanOf<std::byte>(texture->data(), here / "data");
            here.require(made.file.empty() != made.bytes.empty(), "must have exactly one of file and data");
            here.require(made.file.find('\0') == std::string_view::npos, "has a file whose name has a zero");
        }
    checkRange(at / "textures", std::int64_t(surface.textures.size()), 0, kNoTexture - 1);
    if (!stored.slots()) (at / "slots").fail("is missing");
    surface.slots = {reinterpret_cast<const SlotSurface*>(stored.slots()->Data()), stored.slots()->size()};
    checkCount(at / "slots", surface.slots, std::max<std::size_t>(1, view.mesh.slots.size()));
    for (std::size_t s = 0; s < surface.slots.size(); ++s) {
        const Field here = (at / "slots")[s];
        checkUses(surface.slots[s], here, surface);
        checkNumbers(surface.slots[s], here);
        checkMaterials(surface.slots[s].materials, here, view.materials.size());
    }
    return surface;
}

std::size_t SurfaceView::byteCount() const {
    std::size_t bytes = seam_vertices.size_bytes() + seam_corners.size_bytes() + seam_of_corner.size_bytes() +
                        uv.size_bytes() + colors.size_bytes() + turns.size_bytes() + slots.size_bytes();
    for (const TextureView& texture : textures) bytes += texture.bytes.size();
    return bytes;
}

}  // namespace penumbra
