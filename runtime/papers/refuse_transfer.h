#pragma once
#include "formats/asset/asset_file.h"

namespace penumbra {

// Throws Error "NAME: `what`" for an asset of transfer, which lacks what visibility has. Does nothing for another.
template <class Error>
void refuseTransfer(const AssetView& asset, const char* what) {
    if (asset.transfer) throw Error(asset.name + ": " + what);
}

}  // namespace penumbra
