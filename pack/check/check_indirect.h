#pragma once
// Compares the light that bounces of an asset with a bake of transfer (docs/formulas.md, section 15).
#include <string>

#include "formats/asset/asset_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Over some frames, each as a share of the rms of the direct transfer.
struct IndirectCheck {
    std::size_t frames = 0;
    double without = 0;  // the rms of the indirect transfer
    double error = 0;    // the rms of its error
};

struct IndirectChecks {
    IndirectCheck training, held_out;
};

// Throws InvalidInput where the asset or the bake has no light that bounces, where they are of different meshes, or
// where the bake has a frame that the asset lacks; Unsupported for a deforming mesh without the positions of its
// frames.
void checkIndirectFits(const AssetView& asset, const VisibilityHeader& header, const std::string& file);

// Checks the frames of a bake with bounces. Throws what checkIndirectFits() throws.
IndirectChecks checkIndirect(const AssetView& asset, const VisibilityReader& bake, const std::string& file,
                             int threads);

}  // namespace penumbra
