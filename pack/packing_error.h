#pragma once
#include "formats/asset/asset_file.h"

namespace penumbra {

// Sums of squares over vertices, numbers and training frames (those of clips that are not held out).
struct PackingSums {
    double difference = 0;  // numbers of the packed asset - numbers of the exact one
    double signal = 0;      // numbers of the exact asset - its stored mean

    double relative() const;  // sqrt(difference / signal), 0 without signal
};

// Compares two assets of one model, both by the run-time evaluator. `exact` is F32. The result is the same for any
// number of threads.
PackingSums comparePacked(const AssetView& packed, const AssetView& exact, int threads);

}  // namespace penumbra
