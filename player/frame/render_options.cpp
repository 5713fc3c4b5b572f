#include "player/frame/render_options.h"

#include <array>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/picture_text.h"

namespace penumbra {

namespace {

UsageError wrongWord(std::string_view option, std::string_view takes, std::string_view word) {
    return UsageError(std::string(option) + " is " + std::string(takes) + ", not \"" + std::string(word) + "\"");
}

}  // namespace

std::string findProblem(const RenderOptions& options) {
    const auto outside = [](const std::string& option, const std::string& range, double value) {
        std::string text = std::to_string(value);
        text.erase(text.find_last_not_of('0') + 1);
        if (text.back() == '.') text.pop_back();
        return option + " must be " + range + ", not " + text;
    };
    if (options.frame < 0) return outside("--frame", "0 or more", options.frame);
    if (options.width < 1 || options.width > 16384) return outside("--size: the width", "1..16384", options.width);
    if (options.height < 1 || options.height > 16384) return outside("--size: the height", "1..16384", options.height);
    if (options.samples != 1 && options.samples != 2 && options.samples != 4 && options.samples != 8)
        return outside("--aa", "1, 2, 4 or 8", options.samples);
    if (options.exposure && (!(*options.exposure > 0) || !std::isfinite(*options.exposure)))
        return outside("--exposure", "a finite number above 0", double(*options.exposure));
    if (options.sun_map < kSmallestSunMap || options.sun_map > kLargestSunMap)
        return outside("--sun-map", std::to_string(kSmallestSunMap) + ".." + std::to_string(kLargestSunMap),
                       options.sun_map);
    if (!(options.error_max > 0) || !std::isfinite(options.error_max))
        return outside("--error-max", "a finite number above 0", double(options.error_max));
    return "";
}

constexpr std::array<std::string_view, 8> kChannels = {"shaded",  "ao",    "error",      "clusters",
                                                       "normals", "parts", "ao-bounced", "transfer-error"};

std::string_view nameOf(Channel channel) { return kChannels[std::size_t(channel)]; }

Channel parseChannel(std::string_view word) {
    for (std::size_t i = 0; i < kChannels.size(); ++i)
        if (word == kChannels[i]) return Channel(i);
    throw wrongWord("--channel", "shaded, ao, error, clusters, normals, parts, ao-bounced or transfer-error", word);
}

VisibilitySource parseSource(std::string_view word) {
    if (word == "model") return VisibilitySource::kModel;
    if (word == "truth") return VisibilitySource::kTruth;
    throw wrongWord("--source", "model or truth", word);
}

std::optional<EvaluationPath> parsePath(std::string_view word) {
    if (word == "auto") return std::nullopt;
    if (word == "cpu") return EvaluationPath::kCpu;
    if (word == "glsl") return EvaluationPath::kGlsl;
    throw wrongWord("--path", "auto, cpu or glsl", word);
}

Bounces parseBounces(std::string_view word) {
    if (word == "both") return Bounces::kBoth;
    if (word == "direct") return Bounces::kDirect;
    if (word == "indirect") return Bounces::kIndirect;
    throw wrongWord("--bounces", "both, direct or indirect", word);
}

SunChoice parseSuns(std::string_view word) {
    if (word == "auto") return SunChoice::kAuto;
    if (word == "on") return SunChoice::kOn;
    if (word == "off") return SunChoice::kOff;
    throw wrongWord("--suns", "auto, on or off", word);
}

Reflectance parseReflectance(std::string_view word) {
    if (word == "slices") return Reflectance::kSlices;
    if (word == "operators") return Reflectance::kOperators;
    throw wrongWord("--reflectance", "slices or operators", word);
}

std::string_view nameOf(Reflectance reflectance) {
    return reflectance == Reflectance::kSlices ? "slices" : "operators";
}

std::string_view nameOf(LightForm form) {
    constexpr std::array<std::string_view, 3> kNames = {"lobes", "fixed", "rotation"};
    return kNames[std::size_t(form)];
}

LightForm parseLightForm(std::string_view word) {
    if (word == "auto") return ShadingChoice().light_form;
    for (const LightForm form : {LightForm::kLobes, LightForm::kFixed, LightForm::kRotation})
        if (word == nameOf(form)) return form;
    throw wrongWord("--light-form", "auto, lobes, fixed or rotation", word);
}

std::optional<Vec3> parseBackground(std::string_view text) {
    if (text == "transparent") return std::nullopt;
    const std::optional<Vec3> color = parseColor(std::string(text));
    if (!color) throw wrongWord("--background", "transparent, light or R/G/B (linear, 0 or more)", text);
    return color;
}

void parseSize(std::string_view text, int& width, int& height) {
    const std::optional<PictureSize> size = parseSize(std::string(text));
    if (!size) throw wrongWord("--size", "WIDTHxHEIGHT in pixels, each 1..16384", text);
    width = size->width;
    height = size->height;
}

}  // namespace penumbra
