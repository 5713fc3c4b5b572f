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

}  // namespace penumbra
