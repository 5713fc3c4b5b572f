#pragma once
// Errors of predictions, summed frame by frame, and the figures that they give.
#include <span>
#include <string>
#include <vector>

#include "formats/stage/model_file.h"

namespace penumbra {

// Sums over the vertices of a cluster, or of all clusters, frame by frame. F counts frames.
struct FrameErrors {
    std::vector<double> squared;   // [F] |prediction - truth|^2
    std::vector<double> variance;  // [F] |truth - training mean|^2
    std::vector<double> ambient;   // [F] |E(prediction) - E(truth)|, NaN without ambient_weights

    explicit FrameErrors(std::size_t frames = 0) : squared(frames), variance(frames), ambient(frames) {}
    void add(const FrameErrors& other);
};

struct ErrorFigures {
    double relative_error = 0, rms_v = 0, ambient_error = 0;  // docs/formulas.md section 5
};

// Returns the error figures over the given frames.
ErrorFigures figuresOf(const FrameErrors& errors, std::span<const std::size_t> frames, std::size_t vertices);
std::vector<ClipError> errorsByClip(const FrameErrors& errors, const FrameList& list,
                                    const std::vector<std::string>& holdout, std::size_t vertices);

}  // namespace penumbra
