#pragma once
// Makes the materials of a mesh's slots from the looks that its source file describes.
#include <span>
#include <string>
#include <vector>

#include "formats/source/source_looks.h"
#include "formats/stage/brdf_file.h"

namespace penumbra {

struct SourceMaterials {
    std::vector<BrdfFile> materials;    // each once; a material's name is its text for penumbra-fit brdf --analytic
    std::vector<std::string> of_slot;   // [slots] its material; "" where the file has no such slot
    std::vector<std::string> said;      // a line for each slot: its material and its textures
    std::vector<std::string> warnings;  // properties that are not read, and slots without a material
};

// `slots` are those of the mesh. Without any, the materials of all slots of the file are made, or that of the one part
// of a mesh without slots. Slices get `bands` bands over both directions. Throws InvalidInput for a damaged material
// that a slot has.
SourceMaterials materialsOf(const SourceLooks& looks, std::span<const std::string> slots, int bands, int threads);

}  // namespace penumbra
