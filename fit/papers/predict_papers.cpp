#include <cstdio>

#include "fit/papers/lobes/fit_lobe_model.h"
#include "fit/papers/papers.h"
#include "fit/papers/transfer/predict_transfer.h"
#include "formats/stage/stage_file_kind.h"

namespace penumbra {

namespace {

template <class Model>
std::size_t runPredict(const Model& model, const PredictCommand& command, const CommonOptions& common, Report& report) {
    return runPredict(
        command,
        {[&](const VisibilityHeader& poses) { checkCharacter(model, poses, command.poses); },
         [&](const VisibilityReader& poses, const PredictionOutput& to) { predictFile(model, poses, to); }},
        common, report);
}

}  // namespace

bool predictWithPaperModel(const PredictCommand& command, const CommonOptions& common, Report& report) {
    const std::string kind = stageFileKind(command.model);
    if (kind == kTransferFormat.name) {
        const std::size_t frames = runPredict(readTransfer(command.model), command, common, report);
        if (frames > 0 && !common.quiet) std::printf("%zu frames of diffuse transfer\n", frames);
        return true;
    }
    if (kind != kLobesFormat.name) return false;
    const LobeModel model = readLobes(command.model);
    const std::size_t frames = runPredict(model, command, common, report);
    if (frames > 0 && !common.quiet) std::printf("%zu frames of %zu zonal lobes a vertex\n", frames, model.lobes);
    return true;
}

}  // namespace penumbra
