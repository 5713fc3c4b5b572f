#pragma once
// Writes the lights, and the materials of a mesh's slots, which every kind of asset stores.
#include <span>
#include <vector>

#include "formats/common/slot_choice.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"
#include "pack/sections/asset_writer.h"

namespace penumbra {

Offset<fbs::Light> writeLightSection(FlatBufferBuilder& builder, const LightFile& light);

// Throws InvalidInput when a material or a light is given twice, or when there are too many.
void checkNames(std::span<const BrdfFile> materials, std::span<const LightFile> lights);

// Throws Unsupported when the mesh lacks what a material needs.
void checkLooks(const Mesh& mesh, std::span<const BrdfFile> materials);

// Returns the material of each slot: the one that was chosen, or else the one of this name in `of_slot` ([slots] or
// empty; "": none), or else the first. Empty without both. Throws UsageError when a slot or its material does not
// exist.
std::vector<std::uint16_t> slotMaterials(const Mesh& mesh, std::span<const BrdfFile> materials,
                                         std::span<const std::string> of_slot, std::span<const SlotChoice> choices);

}  // namespace penumbra
