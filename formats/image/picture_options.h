#pragma once
// How a picture of a light is to be read, and what was done. Every command that reads such a picture takes all of these
// options (light_picture_flags.h declares them once), and one reader serves them all (picture_rows.h).
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct PictureOptions {
    std::string layout;        // latlong, angular, ball or cube; "": what the file says, else by the picture's shape
    std::string layer;         // an OpenEXR layer or part; "": the picture, or the only layer
    std::string colorspace;    // a name of color_space.h; "": what the file says, else linear Rec.709
    std::optional<Vec3> fill;  // colour of pixels that a cropped file lacks, in the file's own colours
    bool any_shape = false;    // a photograph: no shape of a light is looked for
    bool repair = false;       // replace pixels with NaN or infinity by the mean of their neighbours
};

// Returns the field of an option that was given, or null. Lights that are no pictures refuse it.
inline const char* givenOption(const PictureOptions& options) {
    if (!options.layout.empty()) return "layout";
    if (!options.layer.empty()) return "layer";
    if (!options.colorspace.empty()) return "colorspace";
    if (options.fill) return "fill";
    return options.repair ? "repair" : nullptr;
}

// Notes of a reader about a picture, for verbs to print: whole sentences without the file's name.
struct PictureNotes {
    std::vector<std::string> lines, warnings;
    std::size_t repaired_pixels = 0;
    double repaired_share = 0;  // share of the picture's pixels
};

}  // namespace penumbra
