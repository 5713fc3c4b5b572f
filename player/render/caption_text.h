#pragma once
// Writes captions on pictures.
#include <string>
#include <string_view>
#include <vector>

#include "formats/image/image_file.h"

namespace penumbra {

// Draws text in a bitmap font of 6 x 13 pixels (caption_glyphs.h), clipped at the picture's edges. `color` is linear.
// A character that is not printable ASCII becomes one '?'.
void drawText(Image& image, int x, int y, std::string_view text, Vec3 color);
int textWidth(std::string_view text);  // pixels
constexpr int kTextHeight = 13;

// Arranges items with two spaces between them in lines of at most `width` pixels. An item that is too long for a line
// is cut and ends in "..". Returns at least one line.
std::vector<std::string> wrapItems(const std::vector<std::string>& items, int width);

}  // namespace penumbra
