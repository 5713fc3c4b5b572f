#pragma once
// Makes the light that bounces small enough for an asset.
#include <functional>

#include "pack/pack_asset.h"

namespace penumbra {

// How an asset stores the light that bounces, and what that costs.
struct PackedIndirect {
    AssetPrecision weights = AssetPrecision::kF16;  // for the regression's weights and units
    // rms of (numbers of the asset - numbers of the model) / rms of (numbers of the model - mean), over training frames
    double error = 0;
    std::size_t components = 0, all_components = 0;
};

// Writes an asset of `model` with every number at `precision`, as an attempt that will be measured.
using WriteAttempt =
    std::function<std::vector<std::byte>(const Model& model, AssetPrecision precision, const PackedIndirect& indirect)>;

// Turns the components of model.indirect to the principal axes of what it predicts, and drops those that add least for
// their bytes until it takes at most `bytes_per_vertex` at `precision`; without a bound it leaves them as they are.
// Each cluster keeps its mean. Throws UsageError where the means alone take more.
PackedIndirect shrinkIndirect(Model& model, AssetPrecision precision, std::optional<double> bytes_per_vertex,
                              const WriteAttempt& write);

}  // namespace penumbra
