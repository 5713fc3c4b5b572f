#pragma once
// Reports a run of `penumbra-player render`, on stdout and in --report.
#include "player/render_command_line.h"

namespace penumbra {

// Reports one picture of one frame.
void reportFrame(const RenderCommand& command, const BatchResult& result, const CommonOptions& common, Report& report);

// Reports every frame, and figures over the frames of each clip, of training and held-out clips, and of all. `gate`
// may be null.
void reportBatch(const BatchPlan& plan, const BatchResult& result, const GateResult* gate, const RenderCommand& command,
                 const CommonOptions& common, Report& report);

}  // namespace penumbra
