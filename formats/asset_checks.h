#pragma once
// Private to asset_file.cpp: from a verified FlatBuffer to a view in which everything is checked.
#include <string>

#include "formats/asset_file.h"

namespace penumbra::fbs {
struct Asset;
}

namespace penumbra {

// InvalidInput: "FILE: FIELD ...".
AssetView viewOfAsset(const fbs::Asset& asset, const std::string& file);

// The parts of it in asset_checks_look.cpp. `at` is the field itself, of slots the file.
struct Field;
std::vector<MaterialView> materialsOf(const fbs::Asset& asset, const Field& at);
std::vector<LightView> lightsOf(const fbs::Asset& asset, const Field& at);
// Without the field every slot has the first material. Reads the mesh and the materials of `asset`.
std::vector<std::uint16_t> slotMaterialsOf(const fbs::Asset& stored, const Field& at, const AssetView& asset);

}  // namespace penumbra
