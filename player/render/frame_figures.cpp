#include "player/render/frame_figures.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "formats/common/csv_field.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// By Figure.
constexpr std::string_view kKeys[std::size(kFigureWords)] = {
    "ambient_error_mean", "ambient_error_p999", "ambient_error_max", "rms_v", "relative_error", "image_rmse", "flip",
    "out_of_range",       "transfer_error"};

}  // namespace

std::string_view keyOf(Figure figure) { return kKeys[std::size_t(figure)]; }

namespace {

double figureOf(const ErrorSums& errors, const ImageError& image, double out_of_range, Figure figure) {
    switch (figure) {
        case Figure::kAmbientMean:
            return errors.ambientMean();
        case Figure::kAmbientTail:
            return errors.tail.quantile(kTailShare);
        case Figure::kAmbientMax:
            return errors.vertices > 0 ? errors.ambient_max : kNotMeasured;
        case Figure::kRmsV:
            return errors.rmsV();
        case Figure::kRelative:
            return errors.relativeError();
        case Figure::kImageRmse:
            return image.rmse();
        case Figure::kFlip:
            return image.flip();
        case Figure::kTransfer:
            return errors.transferMean();
        default:
            return out_of_range;
    }
}

}  // namespace

double figureOf(const FrameRecord& record, Figure figure) {
    return figureOf(record.errors.value_or(ErrorSums()), record.image.value_or(ImageError()), record.out_of_range,
                    figure);
}

void RunFigures::add(const FrameRecord& record) {
    ++frames;
    out_of_range = std::max(out_of_range, record.out_of_range);
    if (record.errors) {
        ++with_truth;
        errors.add(*record.errors);
    }
    if (record.image) image.add(*record.image);
}

double figureOf(const RunFigures& run, Figure figure) {
    return figureOf(run.errors, run.image, run.out_of_range, figure);
}

// --- CSV ------------------------------------------------------------------------------------------------------------

namespace {

std::string number(double value) {
    if (!std::isfinite(value)) return "";
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 9).ptr;
    return {text.data(), end};
}

}  // namespace

std::string figuresCsv(std::span<const FrameRecord> records, const AnimationView& animation) {
    std::string csv = "clip,frame,time,held_out,truth";
    for (const Word<Figure>& figure : kFigureWords) csv += "," + std::string(keyOf(figure.value));
    csv += "\n";
    for (const FrameRecord& record : records) {
        const ClipView& clip = animation.clips[record.at.clip];
        csv += csvField(clip.name) + "," + std::to_string(record.at.number) + "," +
               number(animation.times[record.at.frame]) + "," + (clip.held_out ? "1," : "0,") +
               (record.errors ? "1" : "0");
        for (const Word<Figure>& figure : kFigureWords) csv += "," + number(figureOf(record, figure.value));
        csv += "\n";
    }
    return csv;
}

}  // namespace penumbra
