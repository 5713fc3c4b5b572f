#pragma once
// The search for the asset that PackOptions ask for: precision and components.
#include <functional>

#include "pack/pack_asset.h"

namespace penumbra {

// A whole asset of `model` with the visibility basis at `precision`, `error` stored as its quantization_error.
using WriteAsset = std::function<std::vector<std::byte>(const Model& model, AssetPrecision precision, double error)>;

// packAsset() without materials and lights, which `write` knows.
Packed packWithin(const Model& model, const PackOptions& options, const WriteAsset& write, int threads);

}  // namespace penumbra
