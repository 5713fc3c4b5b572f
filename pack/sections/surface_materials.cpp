#include "pack/sections/surface_materials.h"

#include <algorithm>
#include <cmath>

#include "formats/brdf/principled_slices.h"
#include "formats/image/texture_file.h"
#include "sh/brdf/brdf_sum.h"
#include "sh/reflectance.h"

namespace penumbra {

namespace {

// Collects the parts of materials, each once.
struct PartList {
    SurfaceLook& look;
    PrincipledSlices slices;

    std::uint16_t add(const BrdfSpec& part) {
        std::vector<BrdfFile>& all = look.materials;
        const std::string name = toString(part);
        const auto found = std::ranges::find(all, name, &BrdfFile::name);
        if (found != all.end()) return std::uint16_t(found - all.begin());
        BrdfFile& brdf = all.emplace_back();
        brdf.name = name;
        brdf.slice_order = slices.orders().slice_order;
        brdf.view_order = slices.orders().view_order;
        brdf.even_index = evenIndices(brdf.view_order);
        brdf.slices = slices.slicesOf(part);
        brdf.lobes = {lobeOf(part)};
        return std::uint16_t(all.size() - 1);
    }
};

// Returns between which roughnesses most of a slot lies. A few texels beyond are drawn as the nearest of them.
std::array<double, 2> roughnessRange(const MeshSurface& surface, const SlotSurface& slot) {
    constexpr double kBeyond = 0.02;  // share of the texels, at each end
    const TextureUse& use = slot.use(TextureRole::kMetallicRoughness);
    const auto shown = [&](double green) { return std::clamp(double(slot.roughness) * green, kMinRoughness, 1.0); };
    if (!use.any()) return {shown(1), shown(1)};
    const SurfaceTexture& texture = surface.textures[use.texture];
    const TexturePicture picture = decodeTexture(texture.bytes, texture.name);
    std::array<std::size_t, 256> counts{};
    for (std::size_t at = 1; at < picture.rgb.size(); at += 3) ++counts[picture.rgb[at]];
    const auto quantile = [&](double share) {
        double left = share * double(picture.rgb.size()) / 3;
        std::size_t level = 0;
        while (level < 255 && left >= double(counts[level])) left -= double(counts[level++]);
        return shown(double(level) / 255);
    };
    return {quantile(kBeyond), quantile(1 - kBeyond)};
}

// Between two steps the parts are interpolated, so wide ranges have one in the middle.
std::size_t stepsFor(double range) { return range < 0.05 ? 1 : range < 0.3 ? 2 : 3; }

void addSlot(PartList& parts, const MeshSurface& surface, SlotSurface& slot) {
    Principled dielectric;
    dielectric.specular = double(slot.f90);
    BrdfSpec diffuse = principledDiffuse(dielectric);
    diffuse.parameters.at("f0") = double(std::max({slot.f0.x, slot.f0.y, slot.f0.z}));
    slot.materials.diffuse = parts.add(diffuse);
    const auto [low, high] = roughnessRange(surface, slot);
    const std::size_t steps = stepsFor(high - low);
    slot.materials.steps = std::uint16_t(steps);
    for (std::size_t s = 0; s < steps; ++s) {
        const double roughness = steps == 1 ? (low + high) / 2 : low + (high - low) * double(s) / double(steps - 1);
        const double rounded = std::round(roughness * 100) / 100;  // rounded, so that slots share their parts
        slot.materials.roughness[s] = float(rounded);
        slot.materials.f0[s] = parts.add(principledF0(rounded));
        slot.materials.f90[s] = parts.add(principledF90(rounded));
    }
}

}  // namespace

void addSurfaceMaterials(SurfaceLook& look, int threads) {
    PartList parts{look, {{}, threads}};
    for (SlotSurface& slot : look.surface.slots) addSlot(parts, look.surface, slot);
}

}  // namespace penumbra
