#include "player/gl/screenshot.h"

#include <array>

#include "formats/common/errors.h"
#include "player/gl/gl_objects.h"

namespace penumbra {

namespace {

std::array<float, 256> linearOfSrgbBytes() {
    std::array<float, 256> linear;
    for (int i = 0; i < 256; ++i) linear[std::size_t(i)] = linearFromSrgb(float(i) / 255);
    return linear;
}

}  // namespace

Image readDisplayed(int x, int y, int width, int height) {
    std::vector<std::array<std::uint8_t, 4>> rows(std::size_t(width) * std::size_t(height));
    gl::PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl::ReadPixels(x, y, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rows.data());
    checkGl("reading the window");
    const std::array<float, 256> linear = linearOfSrgbBytes();
    Image image{width, height, {}, {}};
    image.pixels.reserve(rows.size());
    for (int row = height - 1; row >= 0; --row)  // GL's row 0 is the bottom one
        for (int column = 0; column < width; ++column) {
            const auto& p = rows[std::size_t(row) * std::size_t(width) + std::size_t(column)];
            image.pixels.push_back({linear[p[0]], linear[p[1]], linear[p[2]]});
        }
    return image;
}

namespace {

std::string fourDigits(std::size_t number) {
    const std::string digits = std::to_string(number);
    return std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits;
}

std::filesystem::path freeName(const std::filesystem::path& folder, const std::string& stem, const char* extension) {
    for (std::size_t number = 1; number < 10000; ++number) {
        const std::filesystem::path path = folder / (stem + fourDigits(number) + extension);
        if (!std::filesystem::exists(path)) return path;
    }
    throw IoError(folder.string() + ": " + stem + "0001" + extension + " to " + stem + "9999" + extension +
                  " are all there");
}

}  // namespace

std::filesystem::path freeScreenshotName(const std::filesystem::path& folder) {
    return freeName(folder, "view_", ".png");
}

std::filesystem::path freeTurntableName(const std::filesystem::path& folder) {
    return freeName(folder, "turn_", ".y4m");
}

std::filesystem::path sequenceName(const std::filesystem::path& folder, std::string_view clip, std::size_t frame) {
    std::string name(clip);
    for (char& c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
        if (!plain) c = '_';
    }
    return folder / (name + "_" + fourDigits(frame) + ".png");
}

}  // namespace penumbra
