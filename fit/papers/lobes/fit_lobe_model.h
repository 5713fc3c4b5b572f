#pragma once
// Fits Nowrouzezahrai 2008's model of visibility to a whole bake (`penumbra-fit visibility --model zh-lobes`), and
// predicts with it.
#include <optional>

#include "fit/papers/lobes/lobe_maps.h"
#include "fit/visibility/error_figures.h"
#include "fit/visibility/fit_visibility.h"
#include "fit/visibility/predict.h"

namespace penumbra {

struct LobeFitOptions {
    int lobes = 2;     // of a vertex, 1..kMaxVisibilityLobes
    int order = 4;     // SH bands of convention B, 2..kMaxOrder
    int clusters = 0;  // of the tangents; 0: as many as FitOptions takes
    double input_variance = kLobeInputVariance;
    std::vector<std::string> holdout;
    std::optional<FrameList> train_frames;
    int threads = 0;
};

struct LobeFitReport {
    std::size_t train_frames = 0, held_out_frames = 0;
    double fitted = 0;                          // relative error of the lobes before any regression, over all frames
    ErrorFigures train, held_out;               // as of other models
    FrameSpread train_spread, held_out_spread;  // as Nowrouzezahrai 2008 has them; NaN without frames
};

struct LobeModelFit {
    LobeModel model;
    LobeFitReport report;
};

// Throws UsageError for options that do not go with the file, and InvalidInput when it cannot be fitted.
void checkLobeFit(const VisibilityHeader& header, const std::string& file, const LobeFitOptions& options);
// Fits a model to a file that passed checkLobeFit().
LobeModelFit fitLobeModel(const VisibilityReader& reader, const LobeFitOptions& options, const FitObserver& observer);

// Returns the visibility of a pose in the local frames, [V, order^2], in convention B.
std::vector<float> predictLobeValues(const LobeModel& model, std::span<const float> pose, int threads);

// Throws InvalidInput when the poses are those of another character than the model's.
void checkCharacter(const LobeModel& model, const VisibilityHeader& header, const std::string& file);

// Predicts every pose of a file that passed checkCharacter(), in the layout of a bake.
void predictFile(const LobeModel& model, const VisibilityReader& poses, const PredictionOutput& to);

}  // namespace penumbra
