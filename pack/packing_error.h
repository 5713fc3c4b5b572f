#pragma once
#include "formats/asset/asset_file.h"

namespace penumbra {

// Sums of squares over vertices, numbers and training frames (those of clips that are not held out).
struct PackingSums {
    double difference = 0;  // numbers of one asset - numbers of the other
    double signal = 0;      // numbers of the other - its stored mean

    double relative() const;  // sqrt(difference / signal), 0 without signal
};

// Two assets of one model, both with the run-time evaluator; `exact` is F32. Deterministic for any number of threads.
PackingSums comparePacked(const AssetView& packed, const AssetView& exact, int threads);

}  // namespace penumbra
