// Reads Radiance HDR (RGBE): flat pixels, the old run-length code (pixel 1 1 1 n repeats) and the new one (per
// component). As Radiance's own documentation asks, the reader divides by EXPOSURE lines. A component c stands for c
// 2^(e-136).
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "formats/common/errors.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

struct HdrReader {
    std::span<const std::byte> bytes;
    const std::string& name;
    std::size_t position = 0;

    [[noreturn]] void fail(const std::string& what) const { throw InvalidInput(name + ": " + what); }
    std::uint8_t next() {
        if (position >= bytes.size()) fail("cut short");
        return std::uint8_t(bytes[position++]);
    }
    std::string_view line() {
        const auto* begin = reinterpret_cast<const char*>(bytes.data()) + position;
        const std::size_t left = bytes.size() - position;
        const void* end = std::memchr(begin, '\n', left);
        if (!end) fail("header cut short");
        const std::size_t length = std::size_t(static_cast<const char*>(end) - begin);
        position += length + 1;
        return {begin, length > 0 && begin[length - 1] == '\r' ? length - 1 : length};
    }
};

struct HdrHeader {
    int width = 0, height = 0;
    bool bottom_up = false, right_to_left = false;
    double exposure = 1;
};

}  // namespace

bool looksLikeHdr(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE");
}

namespace {

double parseExposure(const HdrReader& in, std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || !(value > 0) || !std::isfinite(value)) in.fail("EXPOSURE is not a positive number");
    return value;
}

// Parses "-Y height +X width", which has rows from the top. The other signs flip; X before Y is a transposed picture.
void parseResolution(const HdrReader& in, std::string_view text, HdrHeader& header) {
    const auto number = [&](int& value) {
        while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || value < 1 || value > kMaxImageSide)
            in.fail("width and height must be from 1 to " + std::to_string(kMaxImageSide));
        text.remove_prefix(std::size_t(end - text.data()));
        while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    };
    if (text.starts_with("-X") || text.starts_with("+X"))
        throw Unsupported(in.name + ": columns before rows in the resolution line");
    if (!text.starts_with("-Y") && !text.starts_with("+Y")) in.fail("no resolution line");
    header.bottom_up = text.front() == '+';
    text.remove_prefix(2);
    number(header.height);
    if (!text.starts_with("-X") && !text.starts_with("+X")) in.fail("no width in the resolution line");
    header.right_to_left = text.front() == '-';
    text.remove_prefix(2);
    number(header.width);
}

HdrHeader readHeader(HdrReader& in) {
    HdrHeader header;
    in.line();  // the magic
    for (std::string_view text = in.line(); !text.empty(); text = in.line()) {
        if (text.starts_with("FORMAT=") && text != "FORMAT=32-bit_rle_rgbe")
            throw Unsupported(in.name + ": " + std::string(text.substr(0, 60)) + "; only 32-bit_rle_rgbe is read");
        if (text.starts_with("EXPOSURE=")) header.exposure *= parseExposure(in, text.substr(9));
    }
    parseResolution(in, in.line(), header);
    return header;
}

using Rgbe = std::array<std::uint8_t, 4>;

// Reads the new code: each component of the row by itself, as runs (count > 128) and literals.
void readPlanarRow(HdrReader& in, std::vector<Rgbe>& row) {
    for (std::size_t component = 0; component < 4; ++component)
        for (std::size_t x = 0; x < row.size();) {
            const std::uint8_t code = in.next();
            const std::size_t count = code > 128 ? code - 128u : code;
            if (count == 0 || count > row.size() - x) in.fail("a run that leaves its row");
            const std::uint8_t value = code > 128 ? in.next() : std::uint8_t(0);
            for (std::size_t i = 0; i < count; ++i) row[x++][component] = code > 128 ? value : in.next();
        }
}

// Reads the old code, of which `first` is already read. Consecutive run pixels are the bytes of one count, lowest
// first.
void readPixelRow(HdrReader& in, Rgbe first, std::vector<Rgbe>& row) {
    int shift = 0;
    for (std::size_t x = 0; x < row.size();) {
        const Rgbe pixel = x == 0 && shift == 0 ? first : Rgbe{in.next(), in.next(), in.next(), in.next()};
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            row[x++] = pixel;
            shift = 0;
            continue;
        }
        if (x == 0 || shift > 24) in.fail("a run without a pixel before it");
        const std::size_t count = std::size_t(pixel[3]) << shift;
        if (count > row.size() - x) in.fail("a run that leaves its row");
        for (std::size_t i = 0; i < count; ++i, ++x) row[x] = row[x - 1];
        shift += 8;
    }
}

void readRow(HdrReader& in, std::vector<Rgbe>& row) {
    const Rgbe first{in.next(), in.next(), in.next(), in.next()};
    const std::size_t width = row.size();
    const bool planar = first[0] == 2 && first[1] == 2 && first[2] < 128 && width >= 8 && width < 32768;
    if (!planar) return readPixelRow(in, first, row);
    if ((std::size_t(first[2]) << 8 | first[3]) != width) in.fail("a row of another width");
    readPlanarRow(in, row);
}

Vec3 toRadiance(Rgbe p, double exposure) {
    if (p[3] == 0) return {};
    const double scale = std::ldexp(1.0, p[3] - 136) / exposure;
    return {float(p[0] * scale), float(p[1] * scale), float(p[2] * scale)};
}

}  // namespace

Image decodeHdr(std::span<const std::byte> bytes, const std::string& name) {
    HdrReader in{bytes, name};
    const HdrHeader header = readHeader(in);
    Image image;
    image.width = header.width;
    image.height = header.height;
    std::vector<Rgbe> row(std::size_t(header.width));
    for (int y = 0; y < header.height; ++y) {  // the picture grows row by row, so that a short file fails early
        readRow(in, row);
        if (header.right_to_left) std::reverse(row.begin(), row.end());
        for (const Rgbe& pixel : row) image.pixels.push_back(toRadiance(pixel, header.exposure));
    }
    if (header.bottom_up)
        for (std::ptrdiff_t y = 0; y < header.height / 2; ++y)
            std::swap_ranges(image.pixels.begin() + y * header.width, image.pixels.begin() + (y + 1) * header.width,
                             image.pixels.end() - (y + 1) * header.width);
    return image;
}

}  // namespace penumbra
