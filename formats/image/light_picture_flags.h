#pragma once
// Adds the options that say how the picture of a light is read, to every verb that reads one. Only the files of verbs
// include this.
#include "formats/common/options.h"
#include "formats/image/color_space.h"
#include "formats/image/picture_options.h"

namespace penumbra {

// "0.5", "R/G/B" or "black".
inline Vec3 parseFill(const std::string& text) {
    if (text == "black") return {};
    if (const std::optional<Vec3> color = parseColor(text)) return *color;
    if (const std::optional<Vec3> gray = parseColor(text + "/" + text + "/" + text)) return *gray;
    throw std::invalid_argument("must be R/G/B, one number for a grey, or black, each 0 or more; not '" + text + "'");
}

inline void addLightPictureOptions(CLI::App& app, PictureOptions& options) {
    constexpr const char* kGroup = "How the picture of a light is read (docs/lights.md)";
    app.add_option(
           "--layout", options.layout,
           "lat-long, angular map (light probe), mirror ball or cube of faces: a cross, six below one another, or "
           "six files; what the file says or by the shape when not given")
        ->check(CLI::IsMember({"latlong", "angular", "ball", "cube"}))
        ->group(kGroup);
    app.add_option("--layer", options.layer, "layer or part of an OpenEXR file that has several")->group(kGroup);
    app.add_option("--colorspace", options.colorspace,
                   "colour space of a file that states none: acescg, aces2065-1, rec2020, p3-d65 or srgb-linear")
        ->check(readableBy(primariesOf))
        ->group(kGroup);
    app.add_option_function<std::string>(
           "--fill",
           [&options](const std::string& text) {
               try {
                   options.fill = parseFill(text);
               } catch (const std::invalid_argument& error) {
                   throw CLI::ValidationError("--fill", error.what());
               }
           },
           "R/G/B of the pixels that a cropped OpenEXR file lacks, black when no colour follows")
        ->expected(0, 1)
        ->default_str("black")
        ->group(kGroup);
    app.add_flag("--repair", options.repair, "pixels with NaN or infinity become the mean of their neighbours")
        ->group(kGroup);
}

// Refuses options of pictures where the light is none: `light` is what it is, as "--analytic".
inline void refuseReading(const PictureOptions& options, const std::string& light) {
    if (const char* given = givenOption(options)) throw BadOption(given, "is for pictures, not for " + light);
}

}  // namespace penumbra
