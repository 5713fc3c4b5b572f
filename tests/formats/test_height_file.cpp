// Heights from files and from closed forms: what they say, and what is refused with the file and the field.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "formats/common/errors.h"
#include "formats/height/height_file.h"
#include "formats/height/raw_heights.h"
#include "formats/image/image_codecs.h"
#include "formats/image/image_file.h"

namespace penumbra::test_height_file {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class HeightFile : public ::testing::Test {
protected:
    fs::path folder = fs::temp_directory_path() / ("heights" + std::to_string(::getpid()));
    void SetUp() override { fs::create_directories(folder); }
    void TearDown() override { fs::remove_all(folder); }

    fs::path write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder / name, std::ios::binary) << bytes;
        return folder / name;
    }
    HeightSource from(const fs::path& file) const {
        HeightSource source;
        source.at = "s.json: /ground/heights";
        source.file = file;
        return source;
    }
};

template <class T>
std::string bytesOf(const std::vector<T>& numbers) {
    return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)};
}

std::string npy(const std::string& type, const std::string& shape, const std::string& data) {
    std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    while ((10 + header.size() + 1) % 64) header += ' ';
    header += '\n';
    const auto size = std::uint16_t(header.size());
    return std::string("\x93NUMPY\x01\x00", 8) + char(size & 255) + char(size >> 8) + header + data;
}

std::string png16(int width, int height, const std::vector<std::uint16_t>& numbers, int type = PNG_COLOR_TYPE_GRAY) {
    std::string out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &out,
        [](png_structp p, png_bytep data, png_size_t size) {
            static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), size);
        },
        nullptr);
    png_set_IHDR(png, info, png_uint_32(width), png_uint_32(height), 16, type, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    const std::size_t channels = type == PNG_COLOR_TYPE_GRAY ? 1 : 3;
    for (int r = 0; r < height; ++r) {
        std::vector<png_byte> row;
        for (std::size_t i = 0; i < std::size_t(width) * channels; ++i) {
            const std::uint16_t n = numbers[std::size_t(r) * std::size_t(width) + i / channels];
            row.push_back(png_byte(n >> 8));
            row.push_back(png_byte(n & 255));
        }
        png_write_row(png, row.data());
    }
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return out;
}

std::vector<float> heightsOf(const HeightSequence& sequence, double seconds = 0) {
    std::vector<float> out(sequence.grid().size());
    sequence.read(seconds, out);
    return out;
}

std::string problemOf(const auto& body) {
    try {
        body();
    } catch (const InvalidInput& problem) {
        return problem.what();
    } catch (const Unsupported& problem) {
        return std::string("unsupported: ") + problem.what();
    }
    return "none";
}

TEST_F(HeightFile, ReadsNumpyWithItsScaleAndCells) {
    HeightSource source = from(write("a.npy", npy("<i2", "2, 3", bytesOf<std::int16_t>({1, 2, 3, -4, 32767, -32768}))));
    source.scale = 0.5;
    source.offset = 10;
    source.cell_rows = 2;
    source.cell_columns = 3;
    const HeightSequence sequence(source);
    EXPECT_EQ(sequence.grid(), (HeightGrid{2, 3, 2, 3}));
    EXPECT_FALSE(sequence.moves());
    EXPECT_EQ(heightsOf(sequence), (std::vector<float>{10.5f, 11, 11.5f, 8, 16393.5f, -16374}));
}

TEST_F(HeightFile, AnArrayOfThreeAxesIsASequenceThatRepeats) {
    HeightSource source = from(write("a.npy", npy("<f4", "3, 1, 2", bytesOf<float>({1, 2, 3, 4, 5, 6}))));
    source.fps = 10;
    const HeightSequence sequence(source);
    EXPECT_TRUE(sequence.moves());
    EXPECT_EQ(heightsOf(sequence, 0.11), (std::vector<float>{3, 4}));
    EXPECT_EQ(heightsOf(sequence, 0.5), (std::vector<float>{5, 6}));
}

TEST_F(HeightFile, ReadsGreyPngAsItsNumbers) {
    const HeightSequence sequence(from(write("a.png", png16(3, 2, {0, 1, 256, 65535, 1000, 40000}))));
    EXPECT_EQ(heightsOf(sequence), (std::vector<float>{0, 1, 256, 65535, 1000, 40000}));
    EXPECT_EQ(sequence.grid().rows, 2);
}

// An OpenEXR picture of float channels, all with the same numbers but for what is added.
void writeChannels(const fs::path& path, int width,
                   const std::vector<std::pair<std::string, std::vector<float>>>& all) {
    const int height = int(all.front().second.size()) / width;
    Imf::Header header(width, height);
    Imf::FrameBuffer buffer;
    for (const auto& [name, numbers] : all) {
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        auto* first = const_cast<char*>(reinterpret_cast<const char*>(numbers.data()));
        buffer.insert(name, Imf::Slice(Imf::FLOAT, first, sizeof(float), sizeof(float) * std::size_t(width)));
    }
    Imf::OutputFile file(path.string().c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
}

TEST_F(HeightFile, ReadsOneChannelOfExrWithItsHoles) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    writeChannels(folder / "one.exr", 2, {{"elevation", {1, 2, nan, 100000}}});
    HeightSource source = from(folder / "one.exr");
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(source)); }),
                HasSubstr("one.exr: row 1, column 0: has no height"));
    source.fill = -1;
    EXPECT_EQ(heightsOf(HeightSequence(source)), (std::vector<float>{1, 2, -1, 100000}));
    writeChannels(folder / "two.exr", 1, {{"elevation", {1, 2}}, {"water", {3, 4}}});
    source.file = folder / "two.exr";
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(source)); }), HasSubstr("has 2 channels, none of them R"));
    source.array = "water";
    EXPECT_EQ(heightsOf(HeightSequence(source)), (std::vector<float>{3, 4}));
    source.array = "snow";
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(source)); }), HasSubstr("two.exr: no channel snow"));
}

TEST_F(HeightFile, ReadsTheRedChannelOfExr) {
    Image image{2, 2, {{0.5f, 9, 9}, {1, 9, 9}, {-2, 9, 9}, {4, 9, 9}}, {}};
    writeExr(folder / "a.exr", image);
    EXPECT_EQ(heightsOf(HeightSequence(from(folder / "a.exr"))), (std::vector<float>{0.5f, 1, -2, 4}));
}

TEST_F(HeightFile, ReadsRawNumbersOfEitherByteOrder) {
    write("a.hdr", "NROWS 1\nNCOLS 2\nNBITS 16\nBYTEORDER M\nLAYOUT BIL\nSKIPBYTES 1\n");
    const HeightSequence big(from(write("a.bil", std::string("x\x01\x02\xff\xfe", 5))));
    EXPECT_EQ(heightsOf(big), (std::vector<float>{258, -2}));
    write("b.hdr", "ncols 2\nnrows 1\npixeltype unsignedint\nulxmap 17.5\n");
    const HeightSequence little(from(write("b.raw", std::string("\x01\x02\xff\xff", 4))));
    EXPECT_EQ(heightsOf(little), (std::vector<float>{513, 65535}));
}

TEST_F(HeightFile, ASequenceOfPicturesHasOneSize) {
    write("w_1.png", png16(1, 1, {5}));
    write("w_2.png", png16(1, 1, {7}));
    EXPECT_EQ(heightsOf(HeightSequence(from(folder / "w_%d.png")), 0.04), (std::vector<float>{7}));
    EXPECT_EQ(filesOf(from(folder / "w_%d.png")).size(), 2u);
    write("w_2.png", png16(2, 1, {7, 8}));
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(from(folder / "w_%d.png")), 0.04); }),
                HasSubstr("w_2.png: has 1 x 2 heights"));
}

TEST_F(HeightFile, ASequenceMayBeOfArrays) {
    write("d_001.npy", npy("<i2", "1, 2", bytesOf<std::int16_t>({1, 2})));
    write("d_002.npy", npy("<f4", "1, 2", bytesOf<float>({3, 4})));
    EXPECT_EQ(heightsOf(HeightSequence(from(folder / "d_%03d.npy")), 0.04), (std::vector<float>{3, 4}));
    EXPECT_EQ(HeightSequence(from(folder)).frameCount(), 2u);
    write("d_002.npy", npy("<f4", "2", bytesOf<float>({3, 4})));
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(from(folder / "d_%03d.npy")), 0.04); }),
                HasSubstr("d_002.npy: f4 [2] is not [rows, columns]"));
    HeightSource source = from(folder / "d_001.npy");
    source.array = "d";
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(source)); }), HasSubstr("/array: is only for .npz and .exr"));
}

TEST_F(HeightFile, WhereNothingIsThereStandsTheFillOrAnError) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    HeightSource source = from(write("a.npy", npy("<f4", "1, 4", bytesOf<float>({1, nan, -9999, INFINITY}))));
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(source)); }),
                HasSubstr("a.npy: row 0, column 1: has no height"));
    source.no_data = -9999;
    source.fill = 3;
    source.scale = 2;
    EXPECT_EQ(heightsOf(HeightSequence(source)), (std::vector<float>{2, 3, 3, 3}));
    write("b.hdr", "NROWS 1\nNCOLS 2\nNODATA -32768\n");
    source = from(write("b.bil", bytesOf<std::int16_t>({-32768, 32767})));
    EXPECT_THAT(problemOf([&] { heightsOf(HeightSequence(source)); }), HasSubstr("column 0: has no height"));
    source.fill = 0;
    EXPECT_EQ(heightsOf(HeightSequence(source)), (std::vector<float>{0, 32767}));
}

TEST_F(HeightFile, RefusesWhatIsTooLargeOrCutShortOrOfAnotherKind) {
    const auto problem = [&](const HeightSource& source) {
        return problemOf([&] { heightsOf(HeightSequence(source)); });
    };
    EXPECT_THAT(problem(from(write("w.npy", npy("<i2", "1, 65537", std::string(2 * 65537, '\0'))))),
                HasSubstr("columns is 65537"));
    EXPECT_THAT(problem(from(write("d.npy", npy("<i2", "4", std::string(8, '\0'))))),
                HasSubstr("is not [rows, columns]"));
    EXPECT_THAT(problem(from(write("z.npy", npy("<i2", "0, 4", "")))), HasSubstr("axis of length 0"));
    EXPECT_THAT(problem(from(write("c.npy", npy("<f4", "2, 2", "12345")))), HasSubstr("c.npy"));
    EXPECT_THAT(problem(from(write("h.npy", npy("<f4", "1, 1", bytesOf<float>({1e30f}))))), HasSubstr("more than 1e7"));
    const std::string picture = png16(64, 64, std::vector<std::uint16_t>(64 * 64, 700));
    EXPECT_THAT(problem(from(write("c.png", picture.substr(0, picture.size() / 2)))), HasSubstr("PNG: is cut short"));
    EXPECT_THAT(problem(from(write("rgb.png", png16(1, 1, {5}, PNG_COLOR_TYPE_RGB)))), HasSubstr("only grey"));
    EXPECT_THAT(problem(from(write("rubbish.png", "rubbish"))), HasSubstr("rubbish.png: is not a file of heights"));
    EXPECT_THAT(problem(from(write("rubbish.exr", "\x76\x2f\x31\x01rubbish"))),
                HasSubstr("rubbish.exr: not a readable"));
    write("b.hdr", "NROWS 2\nNCOLS 2\n");
    EXPECT_THAT(problem(from(write("b.bil", "1234567"))), HasSubstr("has 7 bytes, and its header says 8"));
    HeightSource analytic;
    analytic.at = "s.json: /ground/heights";
    analytic.analytic = "hills";
    EXPECT_THAT(problem(analytic), HasSubstr("/analytic: 'hills' is not waves"));
    analytic.analytic = "waves";
    analytic.scale = 1e9;
    EXPECT_THAT(problem(analytic), HasSubstr("beyond 1e7"));
}

TEST(RawHeader, NamesTheLineThatIsWrong) {
    const auto problem = [](const std::string& text) { return problemOf([&] { parseRawHeader(text, "a.hdr"); }); };
    EXPECT_THAT(problem("NCOLS 4\n"), HasSubstr("a.hdr: has no NROWS"));
    EXPECT_THAT(problem("NROWS x\n"), HasSubstr("a.hdr, line 1: \"x\" is not a number"));
    EXPECT_THAT(problem("\nNROWS 65537\n"), HasSubstr("a.hdr, line 2"));
    EXPECT_THAT(problem("NROWS\n"), HasSubstr("a key without a value"));
    EXPECT_THAT(problem("NROWS 1\nNCOLS 1\nNBITS 32\n"), HasSubstr("unsupported: a.hdr, line 3"));
    EXPECT_THAT(problem("NROWS 1\nNCOLS 1\nLAYOUT BSQ\n"), HasSubstr("unsupported"));
    EXPECT_THAT(problem("NROWS 65536\nNCOLS 65536\n"), HasSubstr("more than 2^26"));
}

TEST(GrayPng, AnyByteThatChangesIsRefusedOrRead) {
    const std::string good = png16(9, 7, std::vector<std::uint16_t>(63, 12345));
    for (std::size_t i = 0; i < good.size(); ++i)
        for (const int flip : {1, 0x80}) {
            std::string bad = good;
            bad[i] = char(bad[i] ^ flip);
            try {
                (void)decodeGrayPng(std::as_bytes(std::span(bad)), "bad", {"", kMaxHeightSide});
            } catch (const InvalidInput&) {
            } catch (const Unsupported&) {
            }
        }
}

}  // namespace
}  // namespace penumbra::test_height_file
