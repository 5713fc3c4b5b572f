#pragma once
// The verbs of penumbra-fit share how they run, and what they tell of it.
#include "fit/visibility/fit_visibility.h"
#include "fit/visibility/predict.h"
#include "formats/common/command_line.h"

namespace penumbra {

// The progress of a verb in the style that --progress and --quiet ask for.
Progress progressOf(const CommonOptions& common, const char* what, const char* unit = "%", double total = 100);
// Reports the phases of a fit, and shows its shares as percent. Both arguments must outlive the result.
FitObserver observerOf(Report& report, Progress& progress);
// Says what a fit would do: --dry-run.
void printFitPlan(const VisibilityHeader& header, const std::string& output);

// The errors of a model of visibility by clip.
struct ClipTable {
    const FrameList& frames;
    const std::vector<ClipError>& clips;
    std::size_t train_frames, held_out_frames;
    const ErrorFigures &train, &held_out;  // over all of them
};
nlohmann::ordered_json toJson(const ErrorFigures& errors);
// Adds train_frames, held_out_frames, train, held_out and clips.
void addToReport(const ClipTable& table, nlohmann::ordered_json& figures);
void print(const ClipTable& table);

// The run of `penumbra-fit predict`, which is the same for every kind of model.
struct PredictCommand {
    std::string model, poses, output;

    std::vector<std::filesystem::path> inputs() const { return {model, poses}; }
};

// A model that was read, as the run sees it.
struct PosePredictor {
    std::function<void(const VisibilityHeader& poses)> check;  // throws InvalidInput for another character's poses
    std::function<void(const VisibilityReader& poses, const PredictionOutput& to)> predict;
};

// Checks the poses, predicts them all and reports their number. Returns that number, and 0 after a dry run.
std::size_t runPredict(const PredictCommand& command, const PosePredictor& model, const CommonOptions& common,
                       Report& report);

}  // namespace penumbra
