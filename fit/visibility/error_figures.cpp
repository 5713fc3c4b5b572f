#include "fit/visibility/error_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {

ErrorFigures figuresOf(const FrameErrors& errors, std::span<const std::size_t> frames, std::size_t vertices) {
    double squared = 0, variance = 0, ambient = 0;
    for (std::size_t f : frames) {
        squared += errors.squared[f];
        variance += errors.variance[f];
        ambient += errors.ambient[f];
    }
    const double points = double(frames.size()) * double(vertices);
    if (frames.empty()) return {};
    return {variance > 0 ? std::sqrt(squared / variance) : 0, std::sqrt(squared / points / (4 * std::numbers::pi)),
            ambient / points};
}

std::vector<ClipError> errorsByClip(const FrameErrors& errors, const FrameList& list,
                                    std::span<const std::string> held_out, std::size_t vertices) {
    std::vector<ClipError> clips;
    for (std::size_t c = 0; c < list.clip_names.size(); ++c) {
        std::vector<std::size_t> frames;
        for (std::size_t f = 0; f < list.frameCount(); ++f)
            if (list.clip[f] == c) frames.push_back(f);
        const ErrorFigures figures = figuresOf(errors, frames, vertices);
        const std::string& name = list.clip_names[c];
        const bool held = std::find(held_out.begin(), held_out.end(), name) != held_out.end();
        clips.push_back({name, held, figures.relative_error, figures.rms_v, figures.ambient_error});
    }
    return clips;
}

}  // namespace penumbra
