#include "formats/source/source_looks.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"

namespace penumbra {

SourceLooks readSourceLooks(const std::filesystem::path& path) {
    const SourceReader* reader = findReader(path);
    if (!reader || !reader->rig)
        throw Unsupported(path.string() + ": not a file with materials (.glb, .gltf, .vrm, .fbx, .dae and .x are)");
    const RigSource source = reader->rig(path);
    SourceLooks looks;
    looks.files_read = source.files_read;
    std::vector<std::string> slots;
    for (const SourcePart& part : source.parts) {
        const std::size_t slot = slotOf(source, part, slots);
        if (slot == looks.slots.size())
            looks.slots.push_back({slots.back(), part.look});
        else if (looks.slots[slot].look != part.look)
            looks.notes.push_back("slot '" + slots[slot] + "' has several materials of this name: the first is read");
    }
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

}  // namespace penumbra
