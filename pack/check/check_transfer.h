#pragma once
// Holds the run-time evaluator of an asset of transfer against baked truth.
#include <functional>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/stage/transfer_error.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct TransferCheckRow {
    std::string name;
    bool held_out = false;
    std::size_t frames = 0;
    TransferErrors errors;                     // the relative error is NaN where the truth has no training frame
    double ambient_error = 0;                  // mean |E(model) - E(truth)|, E = 2 / sqrt(pi) t_0
    double ambient_p999 = 0, ambient_max = 0;  // see ErrorFigures
};

struct TransferCheck {
    std::vector<TransferCheckRow> clips;
    TransferCheckRow training, held_out;
};

// Throws InvalidInput unless the bake is of the asset's character and has its transfer: diffuse transfer of its order,
// or visibility of one order more.
void checkTransferFits(const AssetView& asset, const VisibilityHeader& truth);

// Tells `progress` how many frames are done. The result is the same for any number of threads.
TransferCheck checkTransfer(const AssetView& asset, const VisibilityReader& truth, int threads,
                            const std::function<void(std::size_t)>& progress);

}  // namespace penumbra
