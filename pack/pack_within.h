#pragma once
// The search for the asset that PackOptions ask for: precision and components.
#include <functional>
#include <optional>

#include "pack/pack_asset.h"

namespace penumbra {

// An asset of `model` with the visibility basis at `precision`. With an `error`, stored as its quantization_error, the
// asset to keep; without one an attempt, to be measured: of a deforming mesh with the bones of its frames in the place
// of its playback.
using WriteAsset =
    std::function<std::vector<std::byte>(const Model& model, AssetPrecision precision, std::optional<double> error)>;

// packAsset() without materials and lights, which `write` knows.
Packed packWithin(const Model& model, const PackOptions& options, const WriteAsset& write, int threads);

}  // namespace penumbra
