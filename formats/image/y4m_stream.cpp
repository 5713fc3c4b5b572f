#include "formats/image/y4m_stream.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <sstream>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxLine = 4096;

// Returns a line without its end; false at the end of the stream.
bool readLine(std::istream& in, std::string& line, const std::string& name) {
    line.clear();
    for (int c = in.get(); c != std::istream::traits_type::eof(); c = in.get()) {
        if (c == '\n') return true;
        line.push_back(char(c));
        if (line.size() > kMaxLine) throw InvalidInput(name + ": has a line of more than 4096 bytes; is it a .y4m?");
    }
    if (!line.empty()) throw InvalidInput(name + ": is cut short");
    return false;
}

int sideOf(std::string_view word, const std::string& name) {
    int side = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), side);
    if (problem != std::errc() || end != word.data() + word.size() || side < 1 || side > kMaxY4mSide)
        throw InvalidInput(name + ": has a side of \"" + std::string(word) + "\" pixels, not 1.." +
                           std::to_string(kMaxY4mSide));
    return side;
}

Y4mChroma chromaOf(const std::string& word, const std::string& name) {
    if (word == "420jpeg" || word == "420") return Y4mChroma::k420Jpeg;
    if (word == "420mpeg2") return Y4mChroma::k420Mpeg2;
    if (word == "444") return Y4mChroma::k444;
    throw Unsupported(name + ": has chroma C" + word + "; C420jpeg, C420mpeg2 and C444 are read");
}

void readWord(const std::string& word, const std::string& name, Y4mHeader& header) {
    const std::string value = word.substr(1);
    const auto printable = [&] {
        return !value.empty() &&
               std::ranges::all_of(value, [](unsigned char c) { return std::isdigit(c) || c == ':'; });
    };
    if (word[0] == 'W') header.width = sideOf(value, name);
    if (word[0] == 'H') header.height = sideOf(value, name);
    if (word[0] == 'C') header.chroma = chromaOf(value, name);
    if (word[0] == 'F' && printable()) header.rate = value;
    if (word[0] == 'A' && printable()) header.aspect = value;
    if (word[0] == 'I' && value != "p" && value != "?") throw Unsupported(name + ": is interlaced (I" + value + ")");
    if (word == "XCOLORRANGE=FULL") header.full_range = true;
}

// How Y, Cb and Cr follow from codes 0..255 of red, green and blue, and back.
struct Range {
    float luma, chroma, black;
};
struct LumaWeights {
    float red, green, blue;
};
constexpr LumaWeights weightsOf(Y4mMatrix matrix) {
    return matrix == Y4mMatrix::k709 ? LumaWeights{0.2126f, 0.7152f, 0.0722f} : LumaWeights{0.299f, 0.587f, 0.114f};
}
Range rangeOf(const Y4mHeader& header) {
    return header.full_range ? Range{1, 1, 0} : Range{219.0f / 255, 224.0f / 255, 16};
}
std::uint8_t rounded(float x) { return std::uint8_t(std::clamp(x, 0.0f, 255.0f) + 0.5f); }

struct ChromaPlane {
    std::span<const std::uint8_t> values;
    int width, height;

    // Bilinear; values at the border reach on.
    float at(float x, float y) const {
        const float left = std::floor(x), top = std::floor(y), right = x - left, down = y - top;
        const auto value = [&](int i, int j) {
            return float(values[std::size_t(std::clamp(j, 0, height - 1)) * std::size_t(width) +
                                std::size_t(std::clamp(i, 0, width - 1))]);
        };
        const int i = int(left), j = int(top);
        return (value(i, j) * (1 - right) + value(i + 1, j) * right) * (1 - down) +
               (value(i, j + 1) * (1 - right) + value(i + 1, j + 1) * right) * down;
    }
};

}  // namespace

std::size_t Y4mHeader::frameBytes() const {
    const std::size_t luma = std::size_t(width) * std::size_t(height);
    return chroma == Y4mChroma::k444 ? 3 * luma : luma + luma / 2;
}

Y4mReader::Y4mReader(std::istream& in, std::string name) : in_(in), name_(std::move(name)) {
    std::string line;
    if (!readLine(in_, line, name_) || !line.starts_with("YUV4MPEG2"))
        throw InvalidInput(name_ + ": does not begin with YUV4MPEG2");
    std::istringstream words(line.substr(9));
    for (std::string word; words >> word;) readWord(word, name_, header_);
    if (header_.width == 0 || header_.height == 0) throw InvalidInput(name_ + ": says no size");
    header_.matrix = usualMatrix(header_.height);
    if (header_.chroma != Y4mChroma::k444 && (header_.width % 2 || header_.height % 2))
        throw Unsupported(name_ + ": has an odd size with chroma of half the size");
}

bool Y4mReader::next(std::vector<std::uint8_t>& planes) {
    std::string line;
    const std::string at = name_ + ": picture " + std::to_string(frames_);
    if (!readLine(in_, line, at)) return false;
    if (!line.starts_with("FRAME")) throw InvalidInput(at + " does not begin with FRAME");
    planes.clear();
    // A stream that claims a large picture is believed a piece at a time.
    constexpr std::size_t kPiece = 1 << 20;
    for (const std::size_t bytes = header_.frameBytes(); planes.size() < bytes;) {
        const std::size_t first = planes.size(), count = std::min(kPiece, bytes - first);
        planes.resize(first + count);
        in_.read(reinterpret_cast<char*>(planes.data() + first), std::streamsize(count));
        if (std::size_t(in_.gcount()) != count) throw InvalidInput(at + " is cut short");
    }
    ++frames_;
    return true;
}

std::string y4mHeaderLine(const Y4mHeader& header) {
    const char* chroma = header.chroma == Y4mChroma::k444        ? "444"
                         : header.chroma == Y4mChroma::k420Mpeg2 ? "420mpeg2"
                                                                 : "420jpeg";
    return "YUV4MPEG2 W" + std::to_string(header.width) + " H" + std::to_string(header.height) + " F" + header.rate +
           " Ip A" + header.aspect + " C" + chroma + (header.full_range ? " XCOLORRANGE=FULL\n" : "\n");
}

void writeY4mFrame(std::ostream& out, const Y4mHeader& header, std::span<const std::uint8_t> planes) {
    assert(planes.size() == header.frameBytes());
    out.write("FRAME\n", 6);
    out.write(reinterpret_cast<const char*>(planes.data()), std::streamsize(planes.size()));
    (void)header;
}

void rgbFromPlanes(const Y4mHeader& header, std::span<const std::uint8_t> planes, std::span<std::uint8_t> rgb) {
    const Range range = rangeOf(header);
    const auto [red_share, green_share, blue_share] = weightsOf(header.matrix);
    const bool half = header.chroma != Y4mChroma::k444;
    const std::size_t luma = std::size_t(header.width) * std::size_t(header.height), size = half ? luma / 4 : luma;
    const int width = half ? header.width / 2 : header.width, height = half ? header.height / 2 : header.height;
    const ChromaPlane cb{planes.subspan(luma, size), width, height},
        cr{planes.subspan(luma + size, size), width, height};
    const float to_left = header.chroma == Y4mChroma::k420Mpeg2 ? 0.0f : 0.25f;  // offset of chroma from luma, in
                                                                                 // pixels of chroma
    for (int y = 0; y < header.height; ++y)
        for (int x = 0; x < header.width; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(header.width) + std::size_t(x);
            const float u = half ? 0.5f * float(x) - to_left : float(x), v = half ? 0.5f * float(y) - 0.25f : float(y);
            const float l = (float(planes[i]) - range.black) / range.luma;
            const float b = (cb.at(u, v) - 128) / range.chroma, r = (cr.at(u, v) - 128) / range.chroma;
            rgb[3 * i] = rounded(l + 2 * (1 - red_share) * r);
            rgb[3 * i + 1] = rounded(l - (2 * blue_share * (1 - blue_share) * b + 2 * red_share * (1 - red_share) * r) /
                                             green_share);
            rgb[3 * i + 2] = rounded(l + 2 * (1 - blue_share) * b);
        }
}

void planesFromRgb(const Y4mHeader& header, std::span<const std::uint8_t> rgb, std::span<std::uint8_t> planes) {
    const Range range = rangeOf(header);
    const auto [red_share, green_share, blue_share] = weightsOf(header.matrix);
    const bool half = header.chroma != Y4mChroma::k444;
    const std::size_t luma = std::size_t(header.width) * std::size_t(header.height), size = half ? luma / 4 : luma;
    std::vector<float> blue(luma), red(luma);
    for (std::size_t i = 0; i < luma; ++i) {
        const float r = rgb[3 * i], g = rgb[3 * i + 1], b = rgb[3 * i + 2],
                    l = red_share * r + green_share * g + blue_share * b;
        planes[i] = rounded(range.black + range.luma * l);
        blue[i] = 128 + range.chroma * (b - l) / (2 * (1 - blue_share));
        red[i] = 128 + range.chroma * (r - l) / (2 * (1 - red_share));
    }
    const int step = half ? 2 : 1;
    std::size_t next = luma;
    for (const std::vector<float>* from : {&blue, &red})
        for (int y = 0; y < header.height; y += step)
            for (int x = 0; x < header.width; x += step) {
                const auto at = [&](int dx, int dy) {
                    return (*from)[std::size_t(y + dy) * std::size_t(header.width) +
                                   std::size_t(std::clamp(x + dx, 0, header.width - 1))];
                };
                float value = at(0, 0);
                if (header.chroma == Y4mChroma::k420Jpeg) value = 0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
                if (header.chroma == Y4mChroma::k420Mpeg2)
                    value = 0.125f * (at(-1, 0) + 2 * at(0, 0) + at(1, 0) + at(-1, 1) + 2 * at(0, 1) + at(1, 1));
                planes[next++] = rounded(value);
            }
    assert(next == luma + 2 * size);
    (void)size;
}

}  // namespace penumbra
