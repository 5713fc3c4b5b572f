#include "player/screenshot.h"

#include <array>
#include <cmath>

#include "formats/errors.h"
#include "player/gl_objects.h"

namespace penumbra {

static std::array<float, 256> linearOfSrgbBytes() {
    std::array<float, 256> linear;
    for (int i = 0; i < 256; ++i) {
        const float c = float(i) / 255;
        linear[std::size_t(i)] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
    }
    return linear;
}

Image readDisplayed(int width, int height) {
    std::vector<std::array<std::uint8_t, 4>> rows(std::size_t(width) * std::size_t(height));
    gl::PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl::ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rows.data());
    checkGl("reading the window");
    const std::array<float, 256> linear = linearOfSrgbBytes();
    Image image{width, height, {}, {}};
    image.pixels.reserve(rows.size());
    for (int y = height - 1; y >= 0; --y)  // GL's row 0 is the bottom one
        for (int x = 0; x < width; ++x) {
            const auto& p = rows[std::size_t(y) * std::size_t(width) + std::size_t(x)];
            image.pixels.push_back({linear[p[0]], linear[p[1]], linear[p[2]]});
        }
    return image;
}

std::filesystem::path freeScreenshotName(const std::filesystem::path& folder) {
    for (int number = 1; number < 10000; ++number) {
        std::string digits = std::to_string(number);
        digits.insert(0, 4 - digits.size(), '0');
        const std::filesystem::path path = folder / ("view_" + digits + ".png");
        if (!std::filesystem::exists(path)) return path;
    }
    throw IoError(folder.string() + ": view_0001.png to view_9999.png are all there");
}

}  // namespace penumbra
