#include <png.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

// Applies the sRGB transfer function (IEC 61966-2-1) and rounds to 8 bits.
std::uint8_t toSrgb8(float linear) {
    if (!(linear > 0)) return 0;
    const float x = std::min(linear, 1.0f);
    const float encoded = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
    return std::uint8_t(std::lround(encoded * 255));
}

}  // namespace

float linearFromSrgb(float srgb) { return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f); }

std::vector<std::uint8_t> displayedBytes(const Image& image, float exposure) {
    const bool has_alpha = !image.alpha.empty();
    std::vector<std::uint8_t> bytes;
    bytes.reserve(image.pixels.size() * 4);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        // PNG wants the colour of what covers the pixel, whereas Image has it times the coverage.
        const float scale = has_alpha && image.alpha[i] > 0 ? exposure / image.alpha[i] : exposure;
        for (int c = 0; c < 3; ++c) bytes.push_back(toSrgb8(image.pixels[i][c] * scale));
        if (has_alpha) bytes.push_back(std::uint8_t(std::lround(std::clamp(image.alpha[i], 0.0f, 1.0f) * 255)));
    }
    return bytes;
}

std::vector<std::byte> encodePng(const Image& image, float exposure) {
    assert(image.width > 0 && image.height > 0 &&
           image.pixels.size() == std::size_t(image.width) * std::size_t(image.height));
    const std::vector<std::uint8_t> bytes = displayedBytes(image, exposure);
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = png_uint_32(image.width);
    png.height = png_uint_32(image.height);
    png.format = !image.alpha.empty() ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::vector<std::byte> out(size);
    if (!png_image_write_to_memory(&png, out.data(), &size, 0, bytes.data(), 0, nullptr))
        throw IoError(std::string("PNG: ") + png.message);
    out.resize(size);
    return out;
}

}  // namespace penumbra
