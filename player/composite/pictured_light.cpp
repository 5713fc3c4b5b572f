#include "player/composite/pictured_light.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/image/image_file.h"
#include "player/frame/asset_texture.h"

namespace penumbra {

namespace {

Vec3 mixed(Vec3 a, Vec3 b, float t) { return a * (1 - t) + b * t; }
Vec3 linear(Vec3 srgb) { return {linearFromSrgb(srgb.x), linearFromSrgb(srgb.y), linearFromSrgb(srgb.z)}; }

int texelOf(float place, int size, TextureWrap wrap) {
    if (wrap == TextureWrap::kClamp) return std::clamp(int(place * float(size)), 0, size - 1);
    const float turns = wrap == TextureWrap::kMirror ? 2.0f : 1.0f;
    float within = place - turns * std::floor(place / turns);
    if (within > 1) within = 2 - within;
    return std::clamp(int(within * float(size)), 0, size - 1);
}

// The pictures of an asset at its vertices.
class VertexPictures {
public:
    explicit VertexPictures(const AssetView& asset) : surface_(*asset.surface) {
        std::vector<bool> used(surface_.textures.size());
        for (const SlotSurface& slot : surface_.slots)
            for (const TextureRole role : kRoles)
                if (slot.use(role).any()) used[slot.use(role).texture] = true;
        pictures_.resize(used.size());
        for (std::size_t i = 0; i < used.size(); ++i)
            if (used[i]) pictures_[i] = openTexture(asset, surface_.textures[i]);
    }
    // 1 where the role has no picture.
    Vec3 at(const SlotSurface& slot, TextureRole role, std::size_t vertex) const {
        const TextureUse& use = slot.use(role);
        if (!use.any()) return {1, 1, 1};
        const TexturePicture& picture = pictures_[use.texture];
        const Uv& uv = surface_.uvOf(use.uv_set)[vertex];
        const int column = texelOf(uv[0], picture.width, use.wrapU()),
                  row = texelOf(uv[1], picture.height, use.wrapV());
        const std::uint8_t* rgb =
            picture.rgb.data() + 3 * (std::size_t(row) * std::size_t(picture.width) + std::size_t(column));
        return Vec3{float(rgb[0]), float(rgb[1]), float(rgb[2])} / 255;
    }
    Vec3 tint(std::size_t vertex) const {
        if (surface_.colors.empty()) return {1, 1, 1};
        const VertexColor& color = surface_.colors[vertex];
        return Vec3{float(color[0]), float(color[1]), float(color[2])} / 65535;
    }

private:
    static constexpr std::array kRoles = {TextureRole::kBaseColor, TextureRole::kMetallicRoughness,
                                          TextureRole::kEmissive};
    const SurfaceView& surface_;
    std::vector<TexturePicture> pictures_;
};

// Returns the step whose roughness is nearest.
std::size_t stepOf(const SurfaceMaterials& materials, float roughness) {
    std::size_t best = 0;
    for (std::size_t step = 1; step < materials.steps; ++step)
        if (std::abs(materials.roughness[step] - roughness) < std::abs(materials.roughness[best] - roughness))
            best = step;
    return best;
}

}  // namespace

PicturedLight::PicturedLight(const ShadingSet& shading) : looks_(shading.asset().mesh.positions.size()) {
    const AssetView& asset = shading.asset();
    const VertexPictures pictures(asset);
    for (std::size_t v = 0; v < looks_.size(); ++v) {
        const std::size_t s = asset.mesh.slot_of_vertex.empty() ? 0 : asset.mesh.slot_of_vertex[v];
        if (!shading.showsSurface(s)) continue;
        const SlotSurface& slot = asset.surface->slots[s];
        const Vec3 base = slot.base * linear(pictures.at(slot, TextureRole::kBaseColor, v)) * pictures.tint(v);
        const Vec3 metal = pictures.at(slot, TextureRole::kMetallicRoughness, v);
        const float metallic = slot.metallic * metal.z;
        Look& look = looks_[v];
        look.diffuse = base * (1 - metallic);
        look.f0 = mixed(slot.f0, base, metallic);
        look.f90 = slot.f90 * (1 - metallic) + metallic;
        look.emissive = slot.emissive * linear(pictures.at(slot, TextureRole::kEmissive, v));
        if (slot.materials.steps > 0)
            look.f0_term = 1 + shading.surfaceTerms().slopes + 2 * stepOf(slot.materials, slot.roughness * metal.y);
    }
}

void PicturedLight::join(std::span<const Vec3> terms, std::span<Vec3> radiance) const {
    const std::size_t count = looks_.size();
    for (std::size_t v = 0; v < count; ++v) {
        const Look& look = looks_[v];
        radiance[v] = look.diffuse * terms[v] + look.emissive;
        if (look.f0_term == 0) continue;
        radiance[v] += look.f0 * terms[look.f0_term * count + v] + terms[(look.f0_term + 1) * count + v] * look.f90;
    }
}

}  // namespace penumbra
