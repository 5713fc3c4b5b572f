#pragma once
#include <optional>

#include "formats/asset/asset_file.h"

namespace penumbra {

// Throws InvalidInput when `truth` holds no baked frames, or does not have the mesh and SH order that the asset's model
// needs.
void checkTruth(const AssetView& asset, const AssetView& truth);

// Returns the truth's frame for a frame of the asset's animation: same clip, same number, same time. A truth may have
// been baked for only some of the clips.
std::optional<std::size_t> findTruthFrame(const AssetView& asset, const AssetView& truth, std::size_t frame);

// Tells whether the truth has any of the clip's frames.
bool hasTruthOf(const AssetView& asset, const AssetView& truth, const ClipView& clip);

}  // namespace penumbra
