#include "player/render/caption_text.h"

#include "player/render/caption_glyphs.h"

namespace penumbra {

namespace {

static_assert(kTextHeight == kGlyphHeight);

// Tells whether this is a byte of a UTF-8 character after its first.
bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

void drawGlyph(Image& image, int left, int top, char c, Vec3 color) {
    const auto& rows = kCaptionGlyphs[std::size_t((c < kFirstGlyph || c > kLastGlyph ? '?' : c) - kFirstGlyph)];
    for (int row = 0; row < kGlyphHeight; ++row)
        for (int column = 0; column < kGlyphWidth; ++column) {
            const int x = left + column, y = top + row;
            const bool inside = x >= 0 && x < image.width && y >= 0 && y < image.height;
            if (inside && (rows[std::size_t(row)] & (0x80 >> column)) != 0)
                image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)] = color;
        }
}

}  // namespace

void drawText(Image& image, int x, int y, std::string_view text, Vec3 color) {
    for (const char c : text) {
        if (continues(c)) continue;
        drawGlyph(image, x, y, c, color);
        x += kGlyphWidth;
    }
}

namespace {

int characters(std::string_view text) {
    int count = 0;
    for (const char c : text) count += !continues(c);
    return count;
}

}  // namespace

int textWidth(std::string_view text) { return characters(text) * kGlyphWidth; }

namespace {

// Cuts a text to at most `most` characters, and shows the cut by ".." where there is room.
std::string cut(const std::string& text, int most) {
    if (characters(text) <= most) return text;
    const int kept = most > 2 ? most - 2 : most;
    std::size_t end = 0;
    for (int count = 0; end < text.size(); ++end)
        if (!continues(text[end]) && ++count > kept) break;
    return text.substr(0, end) + (most > 2 ? ".." : "");
}

}  // namespace

std::vector<std::string> wrapItems(const std::vector<std::string>& items, int width) {
    const int most = std::max(1, width / kGlyphWidth);
    std::vector<std::string> lines;
    for (const std::string& item : items) {
        if (!lines.empty() && characters(lines.back()) + 2 + characters(item) <= most)
            lines.back() += "  " + item;
        else
            lines.push_back(cut(item, most));
    }
    if (lines.empty()) lines.emplace_back();
    return lines;
}

}  // namespace penumbra
