#pragma once
// Reads and writes video as YUV4MPEG2 (.y4m), which `ffmpeg -f yuv4mpegpipe` speaks on pipes. Three layouts of 8 bits:
// C420jpeg (which is also C420), C420mpeg2 and C444. Colours are in the range that XCOLORRANGE says: limited (16..235)
// where it says nothing. No word of the format says by which matrix they are mixed; as players do, pictures of 720 rows
// and more have ITU-R BT.709, smaller ones BT.601, unless who calls says another.
#include <cstdint>
#include <istream>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

enum class Y4mChroma { k420Jpeg, k420Mpeg2, k444 };

enum class Y4mMatrix { k601, k709 };
constexpr Y4mMatrix usualMatrix(int height) { return height >= 720 ? Y4mMatrix::k709 : Y4mMatrix::k601; }

struct Y4mHeader {
    int width = 0, height = 0;  // even where chroma is 420
    Y4mChroma chroma = Y4mChroma::k420Jpeg;
    bool full_range = false;
    std::string rate = "25:1", aspect = "1:1";  // pictures a second, and a pixel's width to its height
    Y4mMatrix matrix = Y4mMatrix::k601;
    std::size_t frameBytes() const;
    bool operator==(const Y4mHeader&) const = default;
};
constexpr int kMaxY4mSide = 16384;

// Reads a stream picture by picture. `in` outlives it; messages begin with `name`.
class Y4mReader {
public:
    // Reads the header; the matrix is the usual one of its height. Throws InvalidInput for what is none, and
    // Unsupported for another layout, for interlaced pictures and for an odd size with chroma of half the size.
    Y4mReader(std::istream& in, std::string name);
    const Y4mHeader& header() const { return header_; }
    // Reads the planes Y, Cb and Cr of the next picture; false at the end. Throws InvalidInput where it is cut short.
    bool next(std::vector<std::uint8_t>& planes);

private:
    std::istream& in_;
    std::string name_;
    Y4mHeader header_;
    std::size_t frames_ = 0;
};

// Returns the header's line.
std::string y4mHeaderLine(const Y4mHeader& header);
// Writes "FRAME" and the planes.
void writeY4mFrame(std::ostream& out, const Y4mHeader& header, std::span<const std::uint8_t> planes);

// Between planes and codes of red, green and blue [height, width, 3]. Chroma of half the size is interpolated, and
// averaged, where its layout says that it lies.
void rgbFromPlanes(const Y4mHeader& header, std::span<const std::uint8_t> planes, std::span<std::uint8_t> rgb);
void planesFromRgb(const Y4mHeader& header, std::span<const std::uint8_t> rgb, std::span<std::uint8_t> planes);

}  // namespace penumbra
