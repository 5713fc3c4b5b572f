#pragma once
// Decides whether a run's figures are good enough.
#include "player/render/frame_figures.h"

namespace penumbra {

struct ErrorGate {
    Figure figure = Figure::kAmbientMean;
    double above = 0;       // a figure above it is a failure; >= 0
    bool over_run = false;  // one figure over all frames instead of each frame's own
    double percent = 0;     // share of the frames that may fail, 0 <= percent < 100; not with over_run
};

struct GateResult {
    bool passed = false;
    std::vector<std::size_t> failed;  // records above the bound, the worst first
    std::size_t without = 0;          // records that have no such figure: then the gate fails, whatever the others are
    double run = 0;                   // the figure over all frames
    std::string message;              // one sentence that says what failed and names the worst frames
};

// Judges the records. An empty list fails.
GateResult judge(const ErrorGate& gate, std::span<const FrameRecord> records, const AnimationView& animation);

}  // namespace penumbra
