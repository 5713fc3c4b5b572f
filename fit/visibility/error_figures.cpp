#include "fit/visibility/error_figures.h"

#include <cmath>
#include <numbers>

#include "fit/visibility/split_frames.h"

namespace penumbra {

void FrameErrors::add(const FrameErrors& other) {
    for (std::size_t f = 0; f < squared.size(); ++f) {
        squared[f] += other.squared[f];
        variance[f] += other.variance[f];
        ambient[f] += other.ambient[f];
    }
}

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
                                    const std::vector<std::string>& holdout, std::size_t vertices) {
    std::vector<ClipError> clips;
    for (std::size_t c = 0; c < list.clip_names.size(); ++c) {
        std::vector<std::size_t> frames;
        for (std::size_t f = 0; f < list.frameCount(); ++f)
            if (list.clip[f] == c) frames.push_back(f);
        const ErrorFigures figures = figuresOf(errors, frames, vertices);
        const std::string& name = list.clip_names[c];
        clips.push_back({name, isHeldOut(holdout, name), figures.relative_error, figures.rms_v, figures.ambient_error});
    }
    return clips;
}

}  // namespace penumbra
