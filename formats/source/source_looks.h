#pragma once
// The looks of the parts of a character or mesh, as its source file describes them.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/rig/rig_surface.h"
#include "formats/rig/source_look.h"

namespace penumbra {

struct SlotLook {
    std::string slot;  // see Mesh::slots
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

// Gives the slots of a surface the numbers of their looks, adds what is not read to its notes, and returns a line for
// each slot that says its material and its pictures, and which of these could not be read: openTextures() comes before.
// `slots` are those of the mesh. Throws InvalidInput, after `name` of the file, for a damaged look.
std::vector<std::string> setLooks(const SourceLooks& looks, const std::vector<std::string>& slots,
                                  const std::string& name, RigSurface& surface);

}  // namespace penumbra
