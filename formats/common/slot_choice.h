#pragma once
// Which part of a mesh has which material: "SLOT=MATERIAL" on command lines. Slots are called "NODE/MATERIAL" after the
// source file (Mesh::slots).
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

struct SlotChoice {
    std::string slot, material;
};

// Cut at the first '='; UsageError when a side is empty.
SlotChoice parseSlotChoice(const std::string& text);

// Every slot whose whole name, node or material is `name`; where there is none, every slot where one of them begins so.
// UsageError that lists the slots when none does.
std::vector<std::size_t> findSlots(std::span<const std::string_view> slots, std::string_view name);

// The material called `name`, or the only one that begins so; UsageError that lists them.
std::size_t findMaterial(std::span<const std::string_view> materials, std::string_view name);

}  // namespace penumbra
