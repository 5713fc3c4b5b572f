#include <png.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <csetjmp>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
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

namespace {

struct PngWrite {
    std::vector<std::byte> bytes;
    static void add(png_structp png, png_bytep data, png_size_t size) {
        auto& to = static_cast<PngWrite*>(png_get_io_ptr(png))->bytes;
        const auto* from = reinterpret_cast<const std::byte*>(data);
        to.insert(to.end(), from, from + size);
    }
    static void flush(png_structp) {}
};

// libpng leaves by longjmp(), past which no object of ours may live: all of them are the caller's.
bool writeRows(const TexturePicture& picture, PngWrite& out) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return false;
    }
    png_set_write_fn(png, &out, PngWrite::add, PngWrite::flush);
    png_set_IHDR(png, info, png_uint_32(picture.width), png_uint_32(picture.height), 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, 1);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_write_info(png, info);
    for (int y = 0; y < picture.height; ++y)
        png_write_row(png, picture.rgb.data() + std::size_t(y) * std::size_t(picture.width) * 3);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return true;
}

}  // namespace

std::vector<std::byte> encodePng(const TexturePicture& picture) {
    assert(picture.rgb.size() == 3 * std::size_t(picture.width) * std::size_t(picture.height));
    PngWrite out;
    out.bytes.reserve(picture.rgb.size() / 2);
    if (!writeRows(picture, out)) throw IoError("PNG: cannot be encoded");
    return std::move(out.bytes);
}

namespace {

bool writeData(const DataPicture& picture, PngWrite& out) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return false;
    }
    const int type = picture.channels == 1   ? PNG_COLOR_TYPE_GRAY
                     : picture.channels == 3 ? PNG_COLOR_TYPE_RGB
                                             : PNG_COLOR_TYPE_RGB_ALPHA;
    png_set_write_fn(png, &out, PngWrite::add, PngWrite::flush);
    png_set_IHDR(png, info, png_uint_32(picture.width), png_uint_32(picture.height), 8, type, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (int y = 0; y < picture.height; ++y)
        png_write_row(png, picture.bytes.data() + std::size_t(y) * std::size_t(picture.width * picture.channels));
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return true;
}

}  // namespace

void writeDataPng(const std::filesystem::path& path, const DataPicture& picture) {
    assert(picture.bytes.size() == std::size_t(picture.width) * std::size_t(picture.height * picture.channels));
    PngWrite out;
    if (!writeData(picture, out)) throw IoError("PNG: cannot be encoded");
    writeWholeFile(path, out.bytes);
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
