#pragma once
// The errors of a model of visibility by clip, as `penumbra-fit visibility` prints and reports them.
#include <nlohmann/json.hpp>
#include <vector>

#include "fit/visibility/error_figures.h"

namespace penumbra {

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

}  // namespace penumbra
