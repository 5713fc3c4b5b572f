#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/image/image_file.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_image_file {
namespace {

std::filesystem::path scratch(const std::string& name) {
    static const samples::Folder folder("image");
    return folder.path / name;
}

std::vector<std::byte> bytesOf(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    std::vector<std::byte> bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

std::vector<std::byte> bytesOf(const std::string& text) {
    std::vector<std::byte> bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

// Makes values that half floats hold exactly.
Image ramp(int width, int height, bool alpha) {
    Image image;
    image.width = width;
    image.height = height;
    for (int i = 0; i < width * height; ++i) {
        image.pixels.push_back({float(i % 512), float(i % 64) / 64, -0.5f});
        if (alpha) image.alpha.push_back(float(i % 4) / 4);
    }
    return image;
}

TEST(ImageFile, ExrRoundTripIsExactAndDeterministic) {
    for (bool alpha : {false, true}) {
        const Image image = ramp(37, 300, alpha);  // taller than one band of the reader
        const auto path = scratch("round.exr");
        writeExr(path, image);
        const auto first = bytesOf(path);
        const Image back = readImage(path);
        EXPECT_EQ(back.width, 37);
        EXPECT_EQ(back.height, 300);
        EXPECT_EQ(back.pixels, image.pixels);
        EXPECT_EQ(back.alpha, image.alpha);
        writeImage(path, image, 1);
        EXPECT_EQ(bytesOf(path), first);
    }
}

TEST(ImageFile, ExrClampsToHalfSoThatItCanBeReadAgain) {
    Image image = ramp(2, 1, false);
    image.pixels[0] = {1e6f, -1e6f, 65504};
    writeExr(scratch("clamp.exr"), image);
    EXPECT_EQ(readImage(scratch("clamp.exr")).pixels[0], (Vec3{65504, -65504, 65504}));
}

TEST(ImageFile, RejectsEveryTruncation) {
    const auto path = scratch("cut.exr");
    writeExr(path, ramp(9, 40, true));
    const std::vector<std::byte> exr = bytesOf(path);
    ASSERT_NO_THROW(decodeImage(exr, "cut"));
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n";
    for (int row = 0; row < 2; ++row) {
        hdr += std::string("\2\2\0\10", 4);
        for (int component = 0; component < 4; ++component) hdr += "\x88\x80";  // a run of 8
    }
    ASSERT_NO_THROW(decodeImage(bytesOf(hdr), "cut"));
    for (const auto& whole : {exr, bytesOf(hdr)})
        for (std::size_t n = 0; n < whole.size(); ++n) {
            const std::vector<std::byte> cut(whole.data(), whole.data() + n);
            EXPECT_THROW(decodeImage(cut, "cut"), InvalidInput) << "first " << n << " of " << whole.size();
        }
}

std::string hdrFile(const std::string& resolution, const std::string& data, const std::string& header = "") {
    return "#?RADIANCE\n# a comment\n" + header + "FORMAT=32-bit_rle_rgbe\n\n" + resolution + "\n" + data;
}

TEST(ImageFile, HdrFlatPixels) {
    // c 2^(e-136): 128 at exponent 129 is 1, and exponent 0 is black whatever the mantissa is.
    const Image image =
        decodeImage(bytesOf(hdrFile("-Y 1 +X 2", std::string("\x80\x40\x00\x81\x80\x80\x80\x00", 8))), "flat");
    EXPECT_EQ(image.pixels, (std::vector<Vec3>{{1, 0.5f, 0}, {0, 0, 0}}));
}

TEST(ImageFile, HdrOldRunsCountInBytes) {
    // The data are one pixel, then 1 1 1 3 (3 more), and 1 1 1 1 directly after it (256 more).
    const std::string data("\x80\x40\x20\x81\x01\x01\x01\x03\x01\x01\x01\x01", 12);
    const Image image = decodeImage(bytesOf(hdrFile("-Y 1 +X 260", data)), "old");
    ASSERT_EQ(image.pixels.size(), 260u);
    for (Vec3 p : image.pixels) EXPECT_EQ(p, (Vec3{1, 0.5f, 0.25f}));
    EXPECT_THROW(decodeImage(bytesOf(hdrFile("-Y 1 +X 259", data)), "old"), InvalidInput);
    EXPECT_THROW(decodeImage(bytesOf(hdrFile("-Y 1 +X 4", data.substr(4))), "old"), InvalidInput);
}

TEST(ImageFile, HdrNewRunsAndLiterals) {
    std::string data("\x02\x02\x00\x08", 4);
    data += "\x08";  // red: eight literals
    for (int i = 0; i < 8; ++i) data += char(16 * i);
    data += "\x88\x40";                          // green: a run of eight
    data += std::string("\x84\x00\x84\x80", 4);  // blue: two runs of four
    data += "\x88\x81";
    const Image image = decodeImage(bytesOf(hdrFile("-Y 1 +X 8", data)), "new");
    for (int i = 0; i < 8; ++i)
        EXPECT_EQ(image.pixels[std::size_t(i)], (Vec3{float(i) / 8, 0.5f, i < 4 ? 0.0f : 1.0f})) << i;
    data[4] = '\x09';  // a literal run past the end of the row
    EXPECT_THROW(decodeImage(bytesOf(hdrFile("-Y 1 +X 8", data)), "new"), InvalidInput);
}

TEST(ImageFile, HdrFlipsAndExposure) {
    const std::string data("\x80\x00\x00\x81\x40\x00\x00\x81\x20\x00\x00\x81\x10\x00\x00\x81", 16);
    const auto reds = [&](const std::string& resolution, const std::string& header = "") {
        std::vector<float> values;
        for (Vec3 p : decodeImage(bytesOf(hdrFile(resolution, data, header)), "flip").pixels) values.push_back(p.x);
        return values;
    };
    using testing::ElementsAre;
    EXPECT_THAT(reds("-Y 2 +X 2"), ElementsAre(1, 0.5f, 0.25f, 0.125f));
    EXPECT_THAT(reds("+Y 2 +X 2"), ElementsAre(0.25f, 0.125f, 1, 0.5f));
    EXPECT_THAT(reds("-Y 2 -X 2"), ElementsAre(0.5f, 1, 0.125f, 0.25f));
    EXPECT_THAT(reds("-Y 2 +X 2", "EXPOSURE=2\nEXPOSURE= 0.25\n"), ElementsAre(2, 1, 0.5f, 0.25f));
    EXPECT_THROW(reds("+X 2 -Y 2"), Unsupported);
    EXPECT_THROW(reds("-Y 2 +X 0"), InvalidInput);
    EXPECT_THROW(reds("-Y 99999 +X 2"), InvalidInput);
    EXPECT_THROW(reds("-Y 2"), InvalidInput);
    EXPECT_THROW(reds("-Y 2 +X 2", "EXPOSURE=0\n"), InvalidInput);
    EXPECT_THROW(reds("-Y 2 +X 2", "FORMAT=32-bit_rle_cmyk\n"), Unsupported);
}

TEST(ImageFile, BadFilesAreNamed) {
    EXPECT_THROW(readImage(scratch("does_not_exist.exr")), IoError);
    EXPECT_THROW(readImage(scratch("")), IoError);
    std::ofstream(scratch("empty.exr")).close();
    EXPECT_THROW(readImage(scratch("empty.exr")), InvalidInput);
    Image image = ramp(2, 2, false);
    image.pixels[3].y = std::nanf("");
    writeExr(scratch("nan.exr"), image);
    try {
        readImage(scratch("nan.exr"));
        FAIL() << "NaN was read";
    } catch (const InvalidInput& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("nan.exr: NaN or infinity in pixel (1, 1)"));
    }
    EXPECT_THROW(writeImage(scratch("picture.jpg"), image, 1), UsageError);
    EXPECT_THROW(writeImage(scratch("no_such_folder/picture.png"), image, 1), IoError);
}

TEST(ImageFile, PngHasTheSrgbCurve) {
    Image image = ramp(3, 1, false);
    image.pixels = {{0, 0.5f, 1}, {0.00075f, 0.125f, 7}, {-1, 0.1f, 0.0f}};
    image.alpha = {1, 0.5f, 0};
    writePng(scratch("curve.png"), image, 2);
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_file(&png, scratch("curve.png").c_str()));
    EXPECT_EQ(png.width, 3u);
    EXPECT_EQ(png.format & PNG_FORMAT_FLAG_ALPHA, unsigned(PNG_FORMAT_FLAG_ALPHA));
    png.format = PNG_FORMAT_RGBA;
    std::vector<int> values;
    std::vector<png_byte> bytes(PNG_IMAGE_SIZE(png));
    ASSERT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr));
    // The exposure is 2, and colours are divided by alpha: 0.003 is on the linear piece (12.92 x = 9.9), 0.5 is 188,
    // 0.2 is 124. Alpha is not encoded.
    EXPECT_THAT(bytes, testing::ElementsAre(0, 255, 255, 255, 10, 188, 255, 128, 0, 124, 0, 0));
}

TEST(ImageFile, LatLongIsSeenFromInside) {
    const auto near = [](Vec3d a, Vec3d b) { return length(a - b) < 1e-12; };
    EXPECT_TRUE(near(latLongDirection(0.5, 0.5), {1, 0, 0}));
    EXPECT_TRUE(near(latLongDirection(0.75, 0.5), {0, 0, 1}));
    EXPECT_TRUE(near(latLongDirection(0.3, 0), {0, 1, 0}));
    for (double u : {0.01, 0.3, 0.5, 0.99})
        for (double v : {0.01, 0.4, 0.9}) {
            double u2 = 0, v2 = 0;
            latLongCoordinates(latLongDirection(u, v), u2, v2);
            EXPECT_NEAR(u, u2, 1e-12);
            EXPECT_NEAR(v, v2, 1e-12);
        }
}

}  // namespace
}  // namespace penumbra::test_image_file
