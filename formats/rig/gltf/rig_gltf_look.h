#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "formats/rig/source_look.h"

namespace penumbra {

// Reads the metallic-roughness model of a glTF material with KHR_materials_ior, KHR_materials_specular and
// KHR_materials_emissive_strength; the older KHR_materials_pbrSpecularGlossiness becomes the same model. Numbers out
// of range go to the nearest in range, with a note. Damage goes into the look's problem.
SourceLook readGltfLook(const nlohmann::json& material);

// An extension by which a material is seen otherwise than we show it: RigNote::feature and RigNote::effect.
struct GltfEffect {
    std::string feature, effect;
    bool in_bakes = false;  // it changes where light passes, or whether there are shadows
};
// Lists those of a material, without factors that switch them off.
std::vector<GltfEffect> unreadEffects(const nlohmann::json& material);

}  // namespace penumbra
