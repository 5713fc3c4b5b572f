// Reads Radiance HDR (RGBE, XYZE): flat pixels, the old run-length code (pixel 1 1 1 n repeats) and the new one (per
// component). As Radiance's own documentation asks, the reader divides by EXPOSURE and COLORCORR lines, which were
// multiplied into the pixels. A component c stands for c 2^(e-136).
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "formats/common/errors.h"
#include "formats/image/color_space.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

[[noreturn]] void failHdr(const std::string& name, const std::string& what) { throw InvalidInput(name + ": " + what); }

struct HdrHeader {
    int width = 0, height = 0;
    bool bottom_up = false, right_to_left = false, is_xyze = false;
    std::array<double, 3> divisor{1, 1, 1};  // product of the EXPOSURE and COLORCORR lines
    std::optional<Primaries> primaries;
};

}  // namespace

bool looksLikeHdr(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE");
}

namespace {

void skipBlanks(std::string_view& text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
}

std::string_view withoutBlanks(std::string_view text) {
    skipBlanks(text);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

// Reads numbers with blanks between. A sign may stand before each.
template <std::size_t N>
std::array<double, N> readHeaderNumbers(std::string_view text, const std::string& name, const std::string& key) {
    std::array<double, N> values;
    for (double& value : values) {
        skipBlanks(text);
        if (text.starts_with("+")) text.remove_prefix(1);
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || !std::isfinite(value))
            failHdr(name,
                    N == 1 ? key + " is not a positive number" : key + " is not " + std::to_string(N) + " numbers");
        text.remove_prefix(std::size_t(end - text.data()));
    }
    return values;
}

// Parses "-Y height +X width", which has rows from the top. The other signs flip; X before Y is a transposed picture.
void parseResolution(std::string_view text, const std::string& name, HdrHeader& header) {
    const auto number = [&](int& value) {
        skipBlanks(text);
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || value < 1 || value > kMaxImageSide)
            failHdr(name, "width and height must be from 1 to " + std::to_string(kMaxImageSide));
        text.remove_prefix(std::size_t(end - text.data()));
        skipBlanks(text);
    };
    if (text.starts_with("-X") || text.starts_with("+X"))
        throw Unsupported(name + ": columns before rows in the resolution line");
    if (!text.starts_with("-Y") && !text.starts_with("+Y")) failHdr(name, "no resolution line");
    header.bottom_up = text.front() == '+';
    text.remove_prefix(2);
    number(header.height);
    if (!text.starts_with("-X") && !text.starts_with("+X")) failHdr(name, "no width in the resolution line");
    header.right_to_left = text.front() == '-';
    text.remove_prefix(2);
    number(header.width);
}

std::string readHdrLine(BufferedBytes& in, const std::string& name) {
    constexpr std::size_t kMaxLine = 1 << 16;  // history lines of long command lines are shorter
    const std::span<const std::byte> text = in.peek(kMaxLine);
    const void* end = text.empty() ? nullptr : std::memchr(text.data(), '\n', text.size());
    if (!end) failHdr(name, "header cut short");
    const auto* begin = reinterpret_cast<const char*>(text.data());
    std::string line(begin, static_cast<const char*>(end));
    in.skip(line.size() + 1);
    if (line.ends_with('\r')) line.pop_back();
    return line;
}

void readHeaderLine(std::string_view line, const std::string& name, HdrHeader& header) {
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) return;
    const std::string_view key = line.substr(0, equals), value = line.substr(equals + 1);
    if (key == "FORMAT") {
        const std::string_view format = withoutBlanks(value);
        header.is_xyze = format == "32-bit_rle_xyze";
        if (format != "32-bit_rle_rgbe" && !header.is_xyze)
            throw Unsupported(name + ": FORMAT=" + std::string(format.substr(0, 60)) +
                              "; 32-bit_rle_rgbe and 32-bit_rle_xyze are read");
    } else if (key == "EXPOSURE" || key == "COLORCORR") {
        std::array<double, 3> factor;
        if (key == "EXPOSURE")
            factor.fill(readHeaderNumbers<1>(value, name, "EXPOSURE")[0]);
        else
            factor = readHeaderNumbers<3>(value, name, "COLORCORR");
        for (std::size_t i = 0; i < 3; ++i) {
            if (!(factor[i] > 0))
                failHdr(name, key == "EXPOSURE" ? "EXPOSURE is not a positive number"
                                                : "COLORCORR is not 3 positive numbers");
            header.divisor[i] *= factor[i];
        }
    } else if (key == "PRIMARIES") {
        const auto n = readHeaderNumbers<8>(value, name, "PRIMARIES");
        header.primaries = {{n[0], n[1]}, {n[2], n[3]}, {n[4], n[5]}, {n[6], n[7]}};
    }
}

HdrHeader readHdrHeader(BufferedBytes& in, const std::string& name) {
    HdrHeader header;
    readHdrLine(in, name);  // the magic
    for (std::string line = readHdrLine(in, name); !line.empty(); line = readHdrLine(in, name))
        readHeaderLine(line, name, header);
    parseResolution(readHdrLine(in, name), name, header);
    for (double divisor : header.divisor)
        if (!(divisor > 0) || !std::isfinite(divisor) || !std::isfinite(1 / divisor))
            failHdr(name, "the product of EXPOSURE lines is not a positive number");
    return header;
}

// --- Rows -----------------------------------------------------------------------------------------------------------

// The bytes of one row, each component by itself.
using RgbePlanes = std::array<std::vector<std::uint8_t>, 4>;

// Reads bytes of a row that peek() has shown.
struct RowBytes {
    std::span<const std::byte> bytes;
    const std::string& name;
    std::size_t used = 0;

    std::span<const std::byte> take(std::size_t count) {
        if (count > bytes.size() - used) failHdr(name, "cut short");
        used += count;
        return bytes.subspan(used - count, count);
    }
    std::uint8_t next() { return std::uint8_t(take(1)[0]); }
};

// Reads the new code: each component of the row by itself, as runs (count > 128) and literals.
void readPlanarRow(RowBytes& in, RgbePlanes& row) {
    for (std::vector<std::uint8_t>& plane : row)
        for (std::size_t x = 0; x < plane.size();) {
            const std::uint8_t code = in.next();
            const std::size_t count = code > 128 ? code - 128u : code;
            if (count == 0 || count > plane.size() - x) failHdr(in.name, "a run that leaves its row");
            if (code > 128)
                std::memset(&plane[x], in.next(), count);
            else
                std::memcpy(&plane[x], in.take(count).data(), count);
            x += count;
        }
}

// Reads the old code. Consecutive run pixels are the bytes of one count, lowest first.
void readPixelRow(RowBytes& in, RgbePlanes& row) {
    int shift = 0;
    const std::size_t width = row[0].size();
    for (std::size_t x = 0; x < width;) {
        const std::span<const std::byte> bytes = in.take(4);
        std::array<std::uint8_t, 4> pixel;
        std::memcpy(pixel.data(), bytes.data(), 4);
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            for (std::size_t c = 0; c < 4; ++c) row[c][x] = pixel[c];
            ++x;
            shift = 0;
            continue;
        }
        if (x == 0 || shift > 24) failHdr(in.name, "a run without a pixel before it");
        const std::size_t count = std::size_t(pixel[3]) << shift;
        if (count > width - x) failHdr(in.name, "a run that leaves its row");
        for (auto& plane : row) std::fill_n(plane.begin() + std::ptrdiff_t(x), count, plane[x - 1]);
        x += count;
        shift += 8;
    }
}

class HdrRows : public PictureRows {
public:
    HdrRows(const RandomBytes& bytes, const std::string& name, const PictureOptions& options)
        : in_(bytes, kBuffer), name_(name), header_(readHdrHeader(in_, name)) {
        info_.width = header_.width;
        info_.height = header_.height;
        info_.from_the_top = !header_.bottom_up;
        if (!options.layer.empty()) throw BadOption("layer", name + ": a Radiance HDR picture has no layers");
        if (!header_.is_xyze) {
            chooseColors(header_.primaries, options, name, info_);
        } else {
            if (!options.colorspace.empty())
                throw BadOption("colorspace", name + ": holds XYZ, which need no other colour space");
            info_.to_rec709 = xyzToRec709();
            info_.notes.lines.push_back("colours of CIE XYZ become linear Rec.709");
        }
        for (auto& plane : row_) plane.resize(std::size_t(info_.width));
        makeScales();
    }

    void next(PictureBand& band) override {
        const std::size_t width = std::size_t(info_.width);
        constexpr int kBandPixels = 1 << 18;
        band.rows = std::clamp(kBandPixels / info_.width, 1, info_.height - done_);
        band.alpha.clear();
        for (auto& plane : band.color) plane.resize(width * std::size_t(band.rows));
        for (int y = 0; y < band.rows; ++y, ++done_) {
            readRow();
            for (std::size_t c = 0; c < 3; ++c) toRadiance(c, &band.color[c][width * std::size_t(y)]);
        }
    }

private:
    static constexpr std::size_t kBuffer = 1 << 19;  // more than the longest row that makes sense

    void readRow() {
        // At most two bytes for each byte of a row: runs of one pixel.
        RowBytes bytes{in_.peek(8 * std::size_t(info_.width) + 4), name_};
        const std::size_t width = row_[0].size();
        std::array<std::uint8_t, 4> first{};
        if (bytes.bytes.size() >= 4) std::memcpy(first.data(), bytes.bytes.data(), 4);
        const bool planar = first[0] == 2 && first[1] == 2 && first[2] < 128 && width >= 8 && width < 32768;
        if (planar) {
            bytes.take(4);
            if ((std::size_t(first[2]) << 8 | first[3]) != width) failHdr(name_, "a row of another width");
            readPlanarRow(bytes, row_);
        } else {
            readPixelRow(bytes, row_);
        }
        in_.skip(bytes.used);
        if (header_.right_to_left)
            for (auto& plane : row_) std::reverse(plane.begin(), plane.end());
    }

    void makeScales() {
        for (std::size_t c = 0; c < 3; ++c)
            for (int e = 1; e < 256; ++e) scale_[c][std::size_t(e)] = std::ldexp(1.0, e - 136) / header_.divisor[c];
        for (int e = 1; e < 256; ++e) power_[std::size_t(e)] = float(std::ldexp(1.0, e - 136));
    }

    void toRadiance(std::size_t channel, float* out) const {
        const std::uint8_t *value = row_[channel].data(), *exponent = row_[3].data();
        const std::size_t width = row_[0].size();
        if (header_.divisor[channel] == 1)  // a power of two, so that floats are exact
            for (std::size_t x = 0; x < width; ++x) out[x] = float(value[x]) * power_[exponent[x]];
        else
            for (std::size_t x = 0; x < width; ++x) out[x] = float(value[x] * scale_[channel][exponent[x]]);
    }

    BufferedBytes in_;
    std::string name_;
    HdrHeader header_;
    RgbePlanes row_;
    std::array<std::array<double, 256>, 3> scale_{};  // value of mantissa 1, for each exponent
    std::array<float, 256> power_{};                  // the same without a divisor
    int done_ = 0;
};

}  // namespace

std::unique_ptr<PictureRows> openHdr(const RandomBytes& bytes, const std::string& name, const PictureOptions& options) {
    return std::make_unique<HdrRows>(bytes, name, options);
}

}  // namespace penumbra
