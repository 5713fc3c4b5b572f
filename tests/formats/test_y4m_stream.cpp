#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "formats/common/errors.h"
#include "formats/image/y4m_stream.h"

namespace penumbra::test_y4m_stream {
namespace {

std::vector<std::uint8_t> ramp(int width, int height) {
    std::vector<std::uint8_t> rgb;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (const int c : {40 + 150 * x / width, 60 + 120 * y / height, 200 - 100 * x / width})
                rgb.push_back(std::uint8_t(c));
    return rgb;
}

int mostApart(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
    EXPECT_EQ(a.size(), b.size());
    int most = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        most = std::max(most, std::abs(int(a[i]) - int(b[i])));
    return most;
}

std::string streamOf(const Y4mHeader& header, int pictures) {
    const std::vector<std::uint8_t> rgb = ramp(header.width, header.height);
    std::vector<std::uint8_t> planes(header.frameBytes());
    planesFromRgb(header, rgb, planes);
    std::ostringstream out;
    out << y4mHeaderLine(header);
    for (int i = 0; i < pictures; ++i) writeY4mFrame(out, header, planes);
    return out.str();
}

// A smooth picture comes back within a rounding of both ways: 2 codes, 3 where chroma has a quarter of the pixels.
TEST(Y4mStream, PicturesComeBackInEveryLayout) {
    for (const Y4mChroma chroma : {Y4mChroma::k420Jpeg, Y4mChroma::k420Mpeg2, Y4mChroma::k444})
        for (const bool full : {false, true}) {
            const Y4mHeader header{64, 48, chroma, full, "30000:1001", "1:1"};
            std::istringstream in(streamOf(header, 2));
            Y4mReader reader(in, "video");
            EXPECT_EQ(reader.header(), header);
            std::vector<std::uint8_t> planes, rgb(3 * 64 * 48);
            for (int i = 0; i < 2; ++i) {
                ASSERT_TRUE(reader.next(planes));
                rgbFromPlanes(header, planes, rgb);
                EXPECT_LE(mostApart(rgb, ramp(64, 48)), chroma == Y4mChroma::k444 ? 2 : 3);
            }
            EXPECT_FALSE(reader.next(planes));
        }
}

// ITU-R BT.709 in limited range: red has Y 62.6, Cb 102.3, Cr 240; a stream of 720 rows has it without a word.
TEST(Y4mStream, LargePicturesHaveTheColorsOfBt709) {
    std::istringstream in("YUV4MPEG2 W2 H720 C444\n"), small("YUV4MPEG2 W2 H718 C444\n");
    Y4mHeader header = Y4mReader(in, "video").header();
    EXPECT_EQ(header.matrix, Y4mMatrix::k709);
    EXPECT_EQ(Y4mReader(small, "video").header().matrix, Y4mMatrix::k601);
    header.width = header.height = 1;
    const std::vector<std::uint8_t> red{255, 0, 0};
    std::vector<std::uint8_t> planes(3), back(3);
    planesFromRgb(header, red, planes);
    EXPECT_THAT(planes, testing::ElementsAre(63, 102, 240));
    rgbFromPlanes(header, planes, back);
    EXPECT_LE(mostApart(back, red), 2);
}

// ITU-R BT.601 in limited range: white is 235, black 16, and red has Y 81.5, Cb 90.2, Cr 240.
TEST(Y4mStream, ColorsAreThoseOfBt601) {
    const Y4mHeader header{3, 1, Y4mChroma::k444, false, "25:1", "1:1"};
    const std::vector<std::uint8_t> rgb = {255, 255, 255, 0, 0, 0, 255, 0, 0};
    std::vector<std::uint8_t> planes(9);
    planesFromRgb(header, rgb, planes);
    EXPECT_THAT(planes, testing::ElementsAre(235, 16, 81, 128, 128, 90, 128, 128, 240));
}

TEST(Y4mStream, RefusesEveryTruncation) {
    const std::string whole = streamOf({4, 2, Y4mChroma::k420Jpeg, false, "25:1", "1:1"}, 1);
    const std::size_t header = whole.find('\n') + 1;
    for (std::size_t n = 0; n < whole.size(); ++n) {
        std::istringstream in(whole.substr(0, n));
        const auto read = [&] {
            Y4mReader reader(in, "video");
            std::vector<std::uint8_t> planes;
            while (reader.next(planes)) {
            }
        };
        if (n == header)
            EXPECT_NO_THROW(read());  // a video without pictures
        else
            EXPECT_THROW(read(), InvalidInput) << "first " << n << " bytes";
    }
}

TEST(Y4mStream, RefusesWhatItCannotRead) {
    const auto open = [](const std::string& header) {
        std::istringstream in(header + "\n");
        Y4mReader reader(in, "video");
    };
    EXPECT_THROW(open("YUV4MPEG2 W4 H4 C422"), Unsupported);
    EXPECT_THROW(open("YUV4MPEG2 W4 H4 It"), Unsupported);
    EXPECT_THROW(open("YUV4MPEG2 W3 H4"), Unsupported);
    EXPECT_THROW(open("YUV4MPEG2 W4"), InvalidInput);
    EXPECT_THROW(open("YUV4MPEG2 W-4 H4"), InvalidInput);
    EXPECT_THROW(open("YUV4MPEG2 W99999 H4"), InvalidInput);
    EXPECT_THROW(open("RIFF"), InvalidInput);
    EXPECT_NO_THROW(open("YUV4MPEG2 W3 H3 C444"));
}

}  // namespace
}  // namespace penumbra::test_y4m_stream
