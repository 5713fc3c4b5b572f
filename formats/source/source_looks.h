#pragma once
// The looks of the parts of a character or mesh, as its source file describes them.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/rig/source_look.h"

namespace penumbra {

struct SlotLook {
    std::string slot;  // as Mesh::slots
    SourceLook look;
};

struct SourceLooks {
    std::vector<SlotLook> slots;                    // each slot once, in the order of the file
    std::vector<std::string> notes;                 // slots whose parts have several looks
    std::vector<std::filesystem::path> files_read;  // the file and those that it refers to
};

// Reads glTF, FBX, Collada and .x. Throws as readRig() does.
SourceLooks readSourceLooks(const std::filesystem::path& path);

// Returns the material that is shaded: an emission that a texture holds is left out, as the texture is not read.
Principled shownLook(const SourceLook& look);

// Returns the look of a slot, or null where the file has no such slot. A mesh without slots is one part: its look is
// that of the only slot.
const SourceLook* findLook(const SourceLooks& looks, const std::string& slot);

}  // namespace penumbra
