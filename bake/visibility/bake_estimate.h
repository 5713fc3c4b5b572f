#pragma once
// Estimates what a bake will take from a short probe, which poses, traces and compresses some vertices of some
// frames.
#include "bake/visibility/bake_visibility.h"

namespace penumbra {

struct BakeEstimate {
    double seconds = 0;  // with as many threads as the probe, on a machine that nobody else uses
    double bytes = 0;    // size of the output
    double memory = 0;   // bytes
    double journal = 0;  // bytes beside the output until it is whole
    double probe_seconds = 0;
};
// Makes an estimate. Takes about eight seconds of processor time, or more where a single frame takes more. Writes
// nothing.
BakeEstimate estimateBake(const BakePlan& plan, const BakeOptions& options, int threads);

}  // namespace penumbra
