#pragma once
// Holds what was measured of every frame, and over frames.
#include <span>
#include <string>
#include <string_view>

#include "player/render/frame_errors.h"
#include "player/render/frame_list.h"
#include "player/render/image_error.h"

namespace penumbra {

struct FrameRecord {
    ListedFrame at;
    double out_of_range = 0;            // Evaluator::outOfRange()
    std::optional<ErrorSums> errors{};  // if the frame has truth
    std::optional<ImageError> image{};  // if pictures of model and truth were drawn
    std::filesystem::path file{};       // the picture's file, or empty
};

enum class Figure {
    kAmbientMean,
    kAmbientTail,
    kAmbientMax,
    kRmsV,
    kRelative,
    kImageRmse,
    kFlip,
    kOutOfRange,
    kTransfer
};
inline constexpr Word<Figure> kFigureWords[] = {{"ambient-mean", Figure::kAmbientMean},
                                                {"ambient-p999", Figure::kAmbientTail},
                                                {"ambient-max", Figure::kAmbientMax},
                                                {"rms-v", Figure::kRmsV},
                                                {"relative", Figure::kRelative},
                                                {"image-rmse", Figure::kImageRmse},
                                                {"flip", Figure::kFlip},
                                                {"out-of-range", Figure::kOutOfRange},
                                                {"transfer", Figure::kTransfer}};
constexpr std::string_view nameOf(Figure figure) { return wordOf(kFigureWords, figure); }
// Returns the name of a column or key: "ambient_error_mean", ..., "out_of_range".
std::string_view keyOf(Figure figure);

// Returns NaN where the figure was not measured or cannot be formed.
double figureOf(const FrameRecord& record, Figure figure);

// Figures over frames. Sums are taken before they are divided, so that ambient, rms V and relative error are those of
// penumbra-pack check. ambient-max and out-of-range are maxima.
struct RunFigures {
    std::size_t frames = 0, with_truth = 0;
    ErrorSums errors;
    ImageError image;
    double out_of_range = 0;

    void add(const FrameRecord& record);
};
double figureOf(const RunFigures& run, Figure figure);

// Writes a row for each frame below a row of names (RFC 4180). What was not measured is empty. Numbers have 9 digits.
std::string figuresCsv(std::span<const FrameRecord> records, const AnimationView& animation);

}  // namespace penumbra
