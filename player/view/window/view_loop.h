#pragma once
// Runs "penumbra-player view": the window from its opening to its end.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/image/picture_options.h"
#include "player/frame/render_options.h"
#include "player/view/light_blend.h"

namespace penumbra {

struct ViewOptions {
    std::vector<std::filesystem::path> files;  // characters, truths, materials and lights in any order
    std::optional<std::pair<int, int>> size;   // size of the window; unset: the last one, or 1280 x 800
    bool settings = true;                      // read and keep them (view_settings.h)
    std::optional<EvaluationPath> path;        // unset: cpu on software GL, glsl on a GPU
    ShadingChoice shading;                     // wanted forms: lights without lobes, say, are used as they are
    LightFade fade;                            // fade between lights that are switched
    std::filesystem::path screenshots = ".";   // folder
    PictureOptions reading;                    // how to read the pictures of lights
    bool textures = true;                      // pictures of assets that have them are shown
    bool quiet = false;                        // print no line for each picture that is written
};

struct ViewResult {
    std::string gl;
    EvaluationPath path = EvaluationPath::kCpu;
    std::size_t frames = 0;  // frames drawn
    std::string problem;     // with keeping the settings, which is not worth a failure
};

// Returns when the user quits. Unless options.quiet it prints a line on stdout for each picture that it writes: file,
// clip, frame and what was on. Throws the errors of openScene() and ViewWindow. The window shows an IoError of a
// screenshot instead.
ViewResult runView(const ViewOptions& options, int threads);

}  // namespace penumbra
