#pragma once
// Reads which part of a mesh has which material: "SLOT=MATERIAL" on command lines. Slots are called "NODE/MATERIAL"
// after the source file (Mesh::slots).
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

struct SlotChoice {
    std::string slot, material;
};

// Cuts the text at the first '='. A backslash before it makes it part of the slot: "glass\=clear=MATERIAL". Throws
// BadOption when a side is empty.
SlotChoice parseSlotChoice(const std::string& text);

// Returns every slot whose whole name, node or material is `name`; where there is none, every slot of which one of
// these begins so. Throws BadOption, which lists the slots, when no slot fits.
std::vector<std::size_t> findSlots(std::span<const std::string_view> slots, std::string_view name);

}  // namespace penumbra
