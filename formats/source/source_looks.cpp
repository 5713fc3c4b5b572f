#include "formats/source/source_looks.h"

#include <algorithm>
#include <set>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"

namespace penumbra {

namespace {

constexpr const char* kVertexColors = "vertex colors";  // among SourceLook::textures

}  // namespace

SourceLooks readSourceLooks(const std::filesystem::path& path) {
    const SourceReader* reader = findReader(path);
    if (!reader || !reader->rig)
        throw Unsupported(path.string() + ": not a file with materials (.glb, .gltf, .vrm, .fbx, .dae and .x are)");
    const RigSource source = reader->rig(path);
    SourceLooks looks;
    looks.files_read = source.files_read;
    std::vector<std::string> slots;
    std::set<std::size_t> colored;
    for (const SourcePart& part : source.parts) {
        const std::size_t slot = slotOf(source, part, slots);
        if (!part.color.tints.empty()) colored.insert(slot);
        if (slot == looks.slots.size())
            looks.slots.push_back({slots.back(), part.look});
        else if (looks.slots[slot].look != part.look)
            looks.notes.push_back("slot '" + slots[slot] + "' has several materials of this name: the first is read");
    }
    for (const std::size_t slot : colored) looks.slots[slot].look.textures.push_back(kVertexColors);
    return looks;
}

Principled shownLook(const SourceLook& look) {
    Principled shown = look.principled;
    if (std::ranges::find(look.textures, "emissive") != look.textures.end()) shown.emission = {};
    return shown;
}

const SourceLook* findLook(const SourceLooks& looks, const std::string& slot) {
    if (slot.empty() && looks.slots.size() == 1) return &looks.slots.front().look;
    const auto found = std::ranges::find(looks.slots, slot, &SlotLook::slot);
    return found == looks.slots.end() ? nullptr : &found->look;
}

namespace {

void setLook(const Principled& look, SlotSurface& slot) {
    slot.base = toFloat(look.color);
    slot.emissive = toFloat(look.emission);
    slot.f0 = toFloat(dielectricF0(look));
    slot.f90 = float(look.specular);
    slot.metallic = float(look.metallic);
    slot.roughness = float(look.roughness);
}

// Words of SourceLook::textures whose pictures a surface has.
bool isDrawn(const std::string& texture) {
    constexpr const char* kDrawn[] = {"base color", "diffuse",   "metallic-roughness", "normal",
                                      "emissive",   "occlusion", kVertexColors};
    return std::ranges::find(kDrawn, texture) != std::end(kDrawn);
}

}  // namespace

std::vector<std::string> setLooks(const SourceLooks& looks, const std::vector<std::string>& slots,
                                  const std::string& name, RigSurface& surface) {
    std::vector<std::string> said;
    surface.notes.insert(surface.notes.end(), looks.notes.begin(), looks.notes.end());
    for (std::size_t s = 0; s < surface.surface.slots.size(); ++s) {
        const std::string slot = slots.empty() ? "" : slots[s];
        const SourceLook* look = findLook(looks, slot);
        if (!look) continue;
        const std::string where = name + ": slot '" + slot + "': material '" + look->material + "': ";
        if (!look->problem.empty()) throw InvalidInput(where + look->problem);
        SlotSurface& shown = surface.surface.slots[s];
        // A glow whose picture cannot be had would be everywhere.
        setLook(shown.use(TextureRole::kEmissive).any() ? look->principled : shownLook(*look), shown);
        for (const std::string& note : look->notes) surface.notes.push_back(where + note);
        std::string drawn;
        for (const std::string& texture : look->textures) {
            if (isDrawn(texture)) drawn += (drawn.empty() ? "; textures: " : ", ") + texture;
            if (!isDrawn(texture)) surface.notes.push_back(where + "its " + texture + " texture is not read");
        }
        said.push_back("slot '" + slot + "': " + toString(look->principled) + drawn);
    }
    return said;
}

}  // namespace penumbra
