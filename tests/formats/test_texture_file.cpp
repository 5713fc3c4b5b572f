// Tests the pictures that colour a surface: what is read, and what damaged ones do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <array>

#include "formats/common/errors.h"
#include "formats/image/exif_orientation.h"
#include "formats/image/texture_file.h"
#include "tests/formats/tiny_jpeg.h"

namespace penumbra::test_texture_file {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Writes rows of a PNG of any kind. `gamma` other than 0 adds a gAMA chunk.
std::vector<std::byte> pngOf(int width, int height, int depth, int kind, const std::vector<std::uint8_t>& rows,
                             double gamma = 0, int interlace = PNG_INTERLACE_NONE) {
    std::vector<std::byte> out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    const auto append = [](png_structp from, png_bytep data, std::size_t size) {
        auto* to = static_cast<std::vector<std::byte>*>(png_get_io_ptr(from));
        to->insert(to->end(), reinterpret_cast<std::byte*>(data), reinterpret_cast<std::byte*>(data) + size);
    };
    png_set_write_fn(png, &out, append, [](png_structp) {});
    png_set_IHDR(png, info, png_uint_32(width), png_uint_32(height), depth, kind, interlace, 0, 0);
    std::array<png_color, 2> palette{{{10, 20, 30}, {250, 240, 230}}};
    if (kind == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette.data(), 2);
    if (gamma > 0) png_set_gAMA(png, info, gamma);
    png_write_info(png, info);
    const std::size_t stride = png_get_rowbytes(png, info);
    std::vector<png_bytep> at;
    for (int y = 0; y < height; ++y) at.push_back(const_cast<png_bytep>(rows.data()) + std::size_t(y) * stride);
    png_write_image(png, at.data());
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return out;
}

std::string problemOf(const std::vector<std::byte>& bytes) {
    try {
        decodeTexture(bytes, "t");
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

TEST(TextureFile, EveryKindOfPngIsRgbOfEightBitsWithItsFirstRowAtTheTop) {
    EXPECT_THAT(decodeTexture(pngOf(1, 2, 8, PNG_COLOR_TYPE_RGB, {1, 2, 3, 4, 5, 6}), "t").rgb,
                ElementsAre(1, 2, 3, 4, 5, 6));
    EXPECT_THAT(decodeTexture(pngOf(1, 1, 8, PNG_COLOR_TYPE_RGBA, {1, 2, 3, 7}), "t").rgb, ElementsAre(1, 2, 3));
    EXPECT_THAT(decodeTexture(pngOf(1, 1, 8, PNG_COLOR_TYPE_RGBA, {1, 2, 3, 7}), "t").alpha, ElementsAre(7));
    EXPECT_THAT(decodeTexture(pngOf(2, 1, 8, PNG_COLOR_TYPE_GRAY_ALPHA, {9, 7, 8, 6}), "t").alpha, ElementsAre(7, 6));
    EXPECT_TRUE(decodeTexture(pngOf(1, 1, 8, PNG_COLOR_TYPE_RGB, {1, 2, 3}), "t").alpha.empty());
    EXPECT_THAT(decodeTexture(pngOf(2, 1, 1, PNG_COLOR_TYPE_GRAY, {0x40}), "t").rgb,
                ElementsAre(0, 0, 0, 255, 255, 255));
    EXPECT_THAT(decodeTexture(pngOf(1, 1, 16, PNG_COLOR_TYPE_GRAY, {0x80, 0x80}), "t").rgb, ElementsAre(128, 128, 128));
    EXPECT_THAT(decodeTexture(pngOf(2, 1, 1, PNG_COLOR_TYPE_PALETTE, {0x40}), "t").rgb,
                ElementsAre(10, 20, 30, 250, 240, 230));
    std::vector<std::uint8_t> rows(9 * 9 * 3);
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = std::uint8_t(i);
    EXPECT_EQ(decodeTexture(pngOf(9, 9, 8, PNG_COLOR_TYPE_RGB, rows, 0, PNG_INTERLACE_ADAM7), "t").rgb, rows);
}

TEST(TextureFile, GammaOfThePngIsLeftOut) {
    EXPECT_THAT(decodeTexture(pngOf(1, 1, 8, PNG_COLOR_TYPE_RGB, {50, 100, 200}, 1.0), "t").rgb,
                ElementsAre(50, 100, 200));
}

TEST(TextureFile, JpegIsReadAsItsMakerReadsIt) {
    const TexturePicture picture = decodeTexture(samples::tinyJpeg(), "t");
    ASSERT_EQ(picture.width, 16);
    ASSERT_EQ(picture.height, 8);
    for (const auto& [column, rgb] :
         {std::pair(std::size_t(2), std::array{200, 40, 40}), std::pair(std::size_t(13), std::array{30, 60, 220})})
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(picture.rgb[(5 * 16 + column) * 3 + c], rgb[c], 2) << column;
}

TEST(TextureFile, EveryTruncationAndEveryFlippedByteEndsWellAndNamesThePicture) {
    const std::vector<std::byte> png = pngOf(5, 4, 8, PNG_COLOR_TYPE_RGB, std::vector<std::uint8_t>(60, 99));
    for (const std::vector<std::byte>& whole : {png, samples::tinyJpeg()}) {
        for (std::size_t n = 8; n + 2 < whole.size(); ++n)
            EXPECT_THAT(problemOf({whole.begin(), whole.begin() + std::ptrdiff_t(n)}), testing::StartsWith("t: "))
                << "first " << n << " bytes";
        for (std::size_t i = 8; i < whole.size(); ++i) {
            std::vector<std::byte> changed = whole;
            changed[i] ^= std::byte(0xFF);
            problemOf(changed);  // a picture or InvalidInput
        }
    }
}

TEST(TextureFile, SizesThatTheBytesCannotHoldTakeNoMemory) {
    std::vector<std::byte> png = pngOf(5, 4, 8, PNG_COLOR_TYPE_RGB, std::vector<std::uint8_t>(60, 99));
    const auto withSize = [&](std::uint32_t width, std::uint32_t height) {
        std::vector<std::byte> changed = png;
        for (int i = 0; i < 4; ++i) {
            changed[std::size_t(16 + i)] = std::byte(width >> (24 - 8 * i));
            changed[std::size_t(20 + i)] = std::byte(height >> (24 - 8 * i));
        }
        png_uint_32 crc = png_uint_32(0xFFFFFFFF);  // checksum of the chunk's type and data
        for (std::size_t i = 12; i < 29; ++i) {
            crc ^= png_uint_32(changed[i]);
            for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xEDB88320u ^ (crc >> 1) : crc >> 1;
        }
        for (int i = 0; i < 4; ++i) changed[std::size_t(29 + i)] = std::byte((crc ^ 0xFFFFFFFF) >> (24 - 8 * i));
        return problemOf(changed);
    };
    EXPECT_THAT(withSize(16384, 16384), HasSubstr("t: is cut short: too few bytes for 16384 x 16384 pixels"));
    EXPECT_THAT(withSize(16385, 1), HasSubstr("a side has 1..16384"));
    EXPECT_THAT(withSize(0x7FFFFFFF, 0x7FFFFFFF), HasSubstr("t: "));
    std::vector<std::byte> jpeg = samples::tinyJpeg();
    const std::array frame{std::byte(0xFF), std::byte(0xC0), std::byte(0x00), std::byte(0x11)};
    const auto at = std::search(jpeg.begin(), jpeg.end(), frame.begin(), frame.end());
    ASSERT_NE(at, jpeg.end());
    at[5] = at[7] = std::byte(0x3F);  // 16136 x 16144
    EXPECT_THAT(problemOf(jpeg), HasSubstr("too few bytes"));
}

TEST(TextureFile, OtherKindsAreUnsupported) {
    const std::string dds = "DDS |  not a picture that we read";
    EXPECT_THROW(decodeTexture(std::as_bytes(std::span(dds)), "t"), Unsupported);
    const std::string webp("RIFF\0\0\0\0WEBPVP8 ", 16);
    try {
        decodeTexture(std::as_bytes(std::span(webp)), "t");
        ADD_FAILURE() << "WebP is read";
    } catch (const Unsupported& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("t: is WebP, neither"));
    }
    EXPECT_THROW(decodeTexture({}, "t"), Unsupported);
}

// A JPEG whose EXIF says 6 in either order of bytes; cut anywhere it says nothing, and no byte beyond the end is read.
TEST(ExifOrientation, IsReadAndSurvivesEveryTruncation) {
    const std::string head(
        "\xff\xd8\xff\xe0\0\4ab\xff\xe1\0\x22"
        "Exif\0\0",
        18);
    const std::string big("MM\0\x2a\0\0\0\x08\0\1\1\x12\0\3\0\0\0\1\0\6\0\0\0\0\0\0", 26),
        little("II\x2a\0\x08\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0\0", 26);
    for (const std::string& tiff : {big, little}) {
        const std::string all = head + tiff;
        const auto bytes = std::as_bytes(std::span(all));
        EXPECT_EQ(exifOrientation(bytes), 6);
        for (std::size_t n = 0; n < head.size() + 20; ++n) {
            const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(n));
            EXPECT_EQ(exifOrientation(cut), 1) << n;
        }
    }
}

}  // namespace
}  // namespace penumbra::test_texture_file
