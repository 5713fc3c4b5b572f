#pragma once
// Packs a linear model of transfer (penumbra-fit transfer) into a run-time asset, in a table of its own.
#include <span>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/slot_choice.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/transfer_file.h"

namespace penumbra {

struct TransferPackOptions {
    // Precision of the vertices' basis. The basis of the maps is f32 with kF32, else f16. The paper counts f32.
    AssetPrecision precision = AssetPrecision::kF32;
    std::vector<SlotChoice> slots = {};  // slots that are not listed have the first material
};

// Returns a Lambert material of this albedo, "diffuse".
BrdfFile diffuseMaterial(Vec3 albedo);

// Throws Unsupported when no material is Lambert, because transfer is diffuse; the player refuses the others by name.
std::vector<std::byte> packTransfer(const TransferModel& model, std::span<const BrdfFile> materials,
                                    std::span<const LightFile> lights, const TransferPackOptions& options,
                                    const std::string& provenance);

}  // namespace penumbra
