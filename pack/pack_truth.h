#pragma once
// Packs baked frames as they are, for the player to show beside the model.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct TruthOptions {
    AssetPrecision precision = AssetPrecision::kF16;  // or F32
    std::vector<std::string> clips;                   // empty: all of them
};

struct TruthPlan {
    std::vector<std::size_t> frames;  // indices into the visibility file, ascending
    std::size_t bytes = 0;            // size of the moments
};

// Chooses the frames. Throws UsageError for an unknown clip and for more than the 2 GiB that an asset can hold, and
// InvalidInput unless the file has hemisphere_visibility or diffuse_transfer.
TruthPlan planTruth(const VisibilityReader& reader, const TruthOptions& options);

// Writes `output` whole or not at all, and tells `progress` how many frames are done. Throws InvalidInput when a
// moment is not finite.
void packTruth(const VisibilityReader& reader, const TruthPlan& plan, const TruthOptions& options,
               const std::string& provenance, const std::filesystem::path& output,
               const std::function<void(std::size_t)>& progress);

}  // namespace penumbra
