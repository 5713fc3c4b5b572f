#pragma once
// "penumbra-player view": the window from its opening to its end.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "player/render_options.h"

namespace penumbra {

struct ViewOptions {
    std::vector<std::filesystem::path> files;  // characters, truths, materials and lights in any order
    int width = 1280, height = 800;            // of the window
    std::optional<EvaluationPath> path;        // unset: cpu on software GL, glsl on a GPU
    std::filesystem::path screenshots = ".";   // folder
};

struct ViewResult {
    std::string gl;
    EvaluationPath path = EvaluationPath::kCpu;
    std::size_t frames = 0;  // drawn
};

// Returns when the user quits. One line on stdout per screenshot unless quiet: file, clip, frame and what was on.
// Errors: openScene(), ViewWindow; IoError of a screenshot is shown in the window instead.
ViewResult runView(const ViewOptions& options, int threads, bool quiet);

}  // namespace penumbra
