#pragma once
// Reports a run of `penumbra-player render` or `measure`, on stdout and in --report.
#include "formats/common/command_line.h"
#include "player/render/render_batch.h"

namespace penumbra {

// Reports the factor on the colours of shaded pictures, and prints it if it is an automatic one.
void reportExposure(const RenderOptions& options, float exposure, const CommonOptions& common, Report& report);

// Reports one picture of one frame.
void reportFrame(const BatchPlan& plan, const BatchResult& result, const CommonOptions& common, Report& report);

// Reports every frame, and figures over the frames of each clip, of training and held-out clips, and of all.
void reportBatch(const BatchPlan& plan, const BatchResult& result, const CommonOptions& common, Report& report);

}  // namespace penumbra
