#pragma once
// The size and the background of a picture, as every program's command line takes them.
#include <optional>
#include <string>

#include "sh/vec3.h"

namespace penumbra {

constexpr int kMaxPictureSide = 16384;  // pixels
struct PictureSize {
    int width = 0, height = 0;
};

// "640x480". White space and a sign may stand before a number; nothing if the text is not a size. The caller checks the
// range.
std::optional<PictureSize> parseSize(const std::string& text);

// "R/G/B", linear, each finite and 0 or more. White space may stand before a number. Nothing if the text is no colour.
std::optional<Vec3> parseColor(const std::string& text);

}  // namespace penumbra
