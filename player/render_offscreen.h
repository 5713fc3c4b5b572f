#pragma once
// One picture of one frame, without a window.
#include "formats/image_file.h"
#include "player/shot.h"

namespace penumbra {

struct RenderResult {
    Image image;     // linear Rec.709; over the background, or with alpha and the colours multiplied by it
    std::string gl;  // GlContext::description
    EvaluationPath path = EvaluationPath::kCpu;
    double out_of_range = 0;  // Evaluator::outOfRange() of the frame's pose
    struct Error {
        double mean = 0, max = 0;  // |E(model) - E(truth)| over the vertices
    };
    std::optional<Error> ambient_error;  // Channel::kError
};

// `truth` may be null where nothing needs it. Errors: resolveShot(), createGlContext(), makeCamera() (as UsageError).
RenderResult renderOffscreen(const RenderOptions& options, const AssetView& asset, const AssetView* truth, int threads);

}  // namespace penumbra
