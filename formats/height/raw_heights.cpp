#include "formats/height/raw_heights.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>

#include "formats/common/errors.h"
#include "formats/common/random_bytes.h"
#include "sh/height/height_field.h"

namespace penumbra {

namespace {

constexpr std::uint64_t kMaxHeaderBytes = 1 << 16;

std::string upper(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::toupper(c)); });
    return text;
}

double numberOf(const std::string& text, const std::string& where, double least, double most) {
    double value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || !(value >= least && value <= most))
        throw InvalidInput(where + ": \"" + text.substr(0, 40) + "\" is not a number of " + std::to_string(least) +
                           " to " + std::to_string(most));
    return value;
}

int wholeOf(const std::string& text, const std::string& where, double least, double most) {
    const double value = numberOf(text, where, least, most);
    if (value != std::floor(value))
        throw InvalidInput(where + ": \"" + text.substr(0, 40) + "\" is not a whole number");
    return int(value);
}

// Applies one line to the header. Keys that say nothing about the numbers are skipped.
void apply(const std::string& key, const std::string& value, const std::string& where, RawHeader& header) {
    const auto require = [&](bool holds) {
        if (!holds) throw Unsupported(where + ": " + key + " is " + value.substr(0, 40) + ", which is not read");
    };
    if (key == "NROWS") header.rows = wholeOf(value, where, 1, kMaxHeightSide);
    if (key == "NCOLS") header.columns = wholeOf(value, where, 1, kMaxHeightSide);
    if (key == "NBITS") require(value == "16");
    if (key == "NBANDS") require(value == "1");
    if (key == "LAYOUT") require(upper(value) == "BIL");
    if (key == "SKIPBYTES") header.skip = std::uint64_t(wholeOf(value, where, 0, 1 << 30));
    if (key == "NODATA" || key == "NODATA_VALUE") header.no_data = numberOf(value, where, -65536, 65536);
    if (key == "BYTEORDER") {
        require(upper(value) == "I" || upper(value) == "M");
        header.big_endian = upper(value) == "M";
    }
    if (key == "PIXELTYPE") {
        require(upper(value) == "SIGNEDINT" || upper(value) == "UNSIGNEDINT");
        header.is_signed = upper(value) == "SIGNEDINT";
    }
}

}  // namespace

RawHeader parseRawHeader(const std::string& text, const std::string& name) {
    RawHeader header;
    std::istringstream lines(text);
    std::string line, key, value;
    for (int number = 1; std::getline(lines, line); ++number) {
        std::istringstream words(line);
        if (!(words >> key)) continue;
        const std::string where = name + ", line " + std::to_string(number);
        if (!(words >> value)) throw InvalidInput(where + ": a key without a value");
        apply(upper(key), value, where, header);
    }
    for (const auto& [field, count] : {std::pair{"NROWS", header.rows}, {"NCOLS", header.columns}})
        if (count == 0) throw InvalidInput(name + ": has no " + field);
    if (std::size_t(header.rows) * std::size_t(header.columns) > kMaxHeightTexels)
        throw InvalidInput(name + ": NROWS times NCOLS is more than 2^26");
    return header;
}

RawHeights readRawHeights(const std::filesystem::path& path) {
    std::filesystem::path header_path = path;
    header_path.replace_extension(".hdr");
    const RandomBytes header_bytes = openBytes(header_path);
    if (header_bytes.size > kMaxHeaderBytes)
        throw InvalidInput(header_path.string() + ": is longer than a header may be, 64 KiB");
    const std::vector<std::byte> text = readBytes(header_bytes, 0, std::size_t(header_bytes.size));
    const RawHeader header =
        parseRawHeader({reinterpret_cast<const char*>(text.data()), text.size()}, header_path.string());
    const std::size_t count = std::size_t(header.rows) * std::size_t(header.columns);
    const RandomBytes bytes = openBytes(path);
    if (bytes.size != header.skip + 2 * count)
        throw InvalidInput(path.string() + ": has " + std::to_string(bytes.size) + " bytes, and its header says " +
                           std::to_string(header.skip + 2 * count));
    const std::vector<std::byte> raw = readBytes(bytes, header.skip, 2 * count);
    RawHeights out{header.rows, header.columns, std::vector<double>(count)};
    for (std::size_t i = 0; i < count; ++i) {
        const auto low = std::uint16_t(raw[2 * i + (header.big_endian ? 1 : 0)]),
                   high = std::uint16_t(raw[2 * i + (header.big_endian ? 0 : 1)]);
        const auto word = std::uint16_t(high << 8 | low);
        out.numbers[i] = header.is_signed ? double(std::int16_t(word)) : double(word);
        if (header.no_data && out.numbers[i] == *header.no_data)
            out.numbers[i] = std::numeric_limits<double>::quiet_NaN();
    }
    return out;
}

}  // namespace penumbra
