#pragma once
// Captions on pictures.
#include <string>
#include <string_view>
#include <vector>

#include "formats/image/image_file.h"

namespace penumbra {

// Text in a bitmap font of 6 x 13 pixels (caption_glyphs.h), `color` linear; clipped at the picture's edges. What is
// not printable ASCII is drawn as '?', one a UTF-8 character.
void drawText(Image& image, int x, int y, std::string_view text, Vec3 color);
int textWidth(std::string_view text);  // pixels
constexpr int kTextHeight = 13;

// Lines of at most `width` pixels, of items with two spaces between them; an item that is too long alone is cut and
// ends in "..". At least one line.
std::vector<std::string> wrapItems(const std::vector<std::string>& items, int width);

}  // namespace penumbra
