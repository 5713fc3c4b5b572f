#pragma once
// Searches for the asset that PackOptions ask for: its precision and its components.
#include <functional>
#include <optional>

#include "pack/pack_asset.h"

namespace penumbra {

// Writes an asset of `model` with the visibility basis at `precision`. With an `error`, which the asset stores as its
// quantization_error, this is the asset to keep. Without one it is an attempt that will be measured: for a deforming
// mesh it then has the bones of its frames instead of its playback.
using WriteAsset =
    std::function<std::vector<std::byte>(const Model& model, AssetPrecision precision, std::optional<double> error)>;

// Packs as packAsset() does, but leaves materials and lights to `write`.
Packed packWithin(const Model& model, const PackOptions& options, const WriteAsset& write, int threads);

}  // namespace penumbra
