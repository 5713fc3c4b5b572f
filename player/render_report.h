#pragma once
// What `penumbra-player render` says of a run, on stdout and in --report.
#include "player/render_command_line.h"

namespace penumbra {

// One picture of one frame.
void reportFrame(const RenderCommand& command, const BatchResult& result, const CommonOptions& common, Report& report);

// Every frame, and over the frames of each clip, of training and held-out clips, and of all. `gate` may be null.
void reportBatch(const BatchPlan& plan, const BatchResult& result, const GateResult* gate, const RenderCommand& command,
                 const CommonOptions& common, Report& report);

}  // namespace penumbra
