#pragma once
// One picture of one frame, without a window.
#include "formats/image_file.h"
#include "player/shot.h"

namespace penumbra {

struct RenderResult {
    Image image;     // linear Rec.709, times exposure where the channel is light; over the background, else with alpha
    std::string gl;  // GlContext::description
    EvaluationPath path = EvaluationPath::kCpu;
    struct Error {
        double mean = 0, max = 0;  // |E(model) - E(truth)| over the vertices
    };
    std::optional<Error> ambient_error;  // Channel::kError
};

// `truth` may be null where nothing needs it. Errors: resolveShot(), createGlContext(), makeCamera() (as UsageError).
RenderResult renderOffscreen(const RenderOptions& options, const AssetView& asset, const AssetView* truth, int threads);

}  // namespace penumbra
