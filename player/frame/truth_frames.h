#pragma once
#include <optional>

#include "formats/asset/asset_file.h"

namespace penumbra {

// InvalidInput when `truth` holds no baked frames, or not of a mesh and SH order that fit the asset's model.
void checkTruth(const AssetView& asset, const AssetView& truth);

// The truth's frame for a frame of the asset's animation: same clip, same number, same time. A truth may have been
// baked of some clips only.
std::optional<std::size_t> findTruthFrame(const AssetView& asset, const AssetView& truth, std::size_t frame);

// Whether it has any of the clip's frames.
bool hasTruthOf(const AssetView& asset, const AssetView& truth, const ClipView& clip);

}  // namespace penumbra
