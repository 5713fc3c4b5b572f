#pragma once
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

// Sums of squares over vertices, numbers and training frames (those of clips that are not held out; of composed models
// some of them, evenly spread, because these take longer).
struct PackingSums {
    double difference = 0;  // numbers of the packed asset - numbers of the exact one
    double signal = 0;  // numbers of the exact asset - their mean: the stored one, or of composed models the mean here

    double relative() const;  // sqrt(difference / signal), 0 without signal
};

// Lists these frames.
std::vector<std::size_t> packingFrames(const AssetView& asset);

// Compares two assets of one model, both by the run-time evaluator. `exact` is F32. The result is the same for any
// number of threads.
PackingSums comparePacked(const AssetView& packed, const AssetView& exact, int threads);

}  // namespace penumbra
