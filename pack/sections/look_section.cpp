#include "pack/sections/look_section.h"

#include "formats/common/errors.h"
#include "formats/common/find_by_name.h"
#include "formats/common/fp16.h"

namespace penumbra {

namespace {

Offset<fbs::Lobes> writeLobes(FlatBufferBuilder& builder, const LightLobesFit& lobes) {
    if (lobes.directions.empty()) return {};
    std::vector<float> directions;
    for (Vec3d d : lobes.directions) directions.insert(directions.end(), {float(d.x), float(d.y), float(d.z)});
    const std::vector<float> z(lobes.coefficients.begin(), lobes.coefficients.end());
    const auto direction_vector = writeVector<float>(builder, directions);
    const auto z_vector = writeVector<float>(builder, z);
    return fbs::CreateLobes(builder, direction_vector, z_vector);
}

// Extra fields of a factored light. A light without suns needs no window: nothing is subtracted from it.
struct LightFactorSection {
    Offset<flatbuffers::Vector<float>> suns, window;
    std::uint16_t picture_width = 0;
    Offset<flatbuffers::Vector<std::uint16_t>> picture;
};

LightFactorSection writeFactor(FlatBufferBuilder& builder, const LightFile& light) {
    LightFactorSection section;
    if (!light.suns.empty()) {
        std::vector<Sun> suns;
        for (const SunD& sun : light.suns) suns.push_back(floatSun(sun));
        section.suns = writeVector<float>(builder, suns);
        const std::vector<float> window(light.window.begin(), light.window.end());
        if (!window.empty()) section.window = writeVector<float>(builder, window);
    }
    if (light.picture.width > 0) {
        std::vector<std::uint16_t> halves(light.picture.pixels.size());
        floatToHalf(light.picture.pixels, halves);
        section.picture_width = std::uint16_t(light.picture.width);
        section.picture = writeVector<std::uint16_t>(builder, halves);
    }
    return section;
}

}  // namespace

Offset<fbs::Light> writeLightSection(FlatBufferBuilder& builder, const LightFile& light) {
    const std::vector<float> sh(light.sh.begin(), light.sh.end());
    const auto name = builder.CreateString(light.name);
    const auto values = writeVector<float>(builder, sh);
    const auto lobes = writeLobes(builder, light.lobes);
    const LightFactorSection factor = writeFactor(builder, light);
    return fbs::CreateLight(builder, name, std::uint8_t(light.order), values, lobes, factor.suns, factor.window,
                            factor.picture_width, factor.picture);
}

void checkNames(std::span<const BrdfFile> materials, std::span<const LightFile> lights) {
    if (materials.size() > kMaxMaterials)
        throw InvalidInput(std::to_string(materials.size()) + " materials are given; an asset has " +
                           std::to_string(kMaxMaterials) + " at most");
    for (std::size_t i = 0; i < materials.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (materials[i].name == materials[j].name)
                throw InvalidInput("material \"" + materials[i].name + "\" is given twice");
    for (std::size_t i = 0; i < lights.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (lights[i].name == lights[j].name) throw InvalidInput("light \"" + lights[i].name + "\" is given twice");
}

void checkLooks(const Mesh& mesh, std::span<const BrdfFile> materials) {
    for (const BrdfFile& brdf : materials) {
        if (brdf.membrane && !mesh.two_sided)
            throw Unsupported("material \"" + brdf.name + "\": a membrane needs a two-sided bake");
    }
}

std::vector<std::uint16_t> slotMaterials(const Mesh& mesh, std::span<const BrdfFile> materials,
                                         std::span<const std::string> of_slot, std::span<const SlotChoice> choices) {
    if (choices.empty() && of_slot.empty()) return {};
    const std::vector<std::string_view> slots(mesh.slots.begin(), mesh.slots.end());
    std::vector<std::uint16_t> chosen(slots.size(), 0);
    for (std::size_t slot = 0; slot < of_slot.size(); ++slot)
        if (!of_slot[slot].empty()) chosen[slot] = std::uint16_t(findByName(materials, of_slot[slot], "slot"));
    for (const SlotChoice& choice : choices)
        for (const std::size_t slot : findSlots(slots, choice.slot))
            chosen[slot] = std::uint16_t(findByName(materials, choice.material, "slot"));
    return chosen;
}

}  // namespace penumbra
