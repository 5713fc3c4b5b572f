#include "formats/source/source_looks.h"

#include <algorithm>
#include <map>
#include <optional>
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

// Returns the role of a word of SourceLook::textures, or nothing where a surface has no such picture.
std::optional<TextureRole> roleOf(const std::string& texture) {
    static const std::map<std::string, TextureRole> kRoles = {{"base color", TextureRole::kBaseColor},
                                                              {"diffuse", TextureRole::kBaseColor},
                                                              {"metallic-roughness", TextureRole::kMetallicRoughness},
                                                              {"normal", TextureRole::kNormal},
                                                              {"emissive", TextureRole::kEmissive},
                                                              {"occlusion", TextureRole::kOcclusion}};
    const auto found = kRoles.find(texture);
    return found == kRoles.end() ? std::nullopt : std::optional(found->second);
}

// Lists the pictures of a look, and which of them `shown` lacks.
std::string saidTextures(const SourceLook& look, const SlotSurface& shown) {
    std::string said;
    for (const std::string& texture : look.textures) {
        const std::optional<TextureRole> role = roleOf(texture);
        const bool is_read = texture == kVertexColors || (role && shown.use(*role).any());
        said += (said.empty() ? "; textures: " : ", ") + texture + (is_read ? "" : " (not read)");
    }
    return said;
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
        for (const std::string& texture : look->textures)
            if (texture != kVertexColors && !roleOf(texture))
                surface.notes.push_back(where + "its " + texture + " texture is not read");
        said.push_back("slot '" + slot + "': " + toString(look->principled) + saidTextures(*look, shown));
    }
    return said;
}

}  // namespace penumbra
