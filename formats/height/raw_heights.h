#pragma once
// Reads raw 16-bit heights, x.bil or x.raw, beside a header x.hdr as ESRI's BIL files have it: lines of a key and a
// value, of which NROWS, NCOLS, NBITS (16), NBANDS (1), BYTEORDER (I little, M big), PIXELTYPE (SIGNEDINT or
// UNSIGNEDINT), LAYOUT (BIL), SKIPBYTES and NODATA count.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace penumbra {

struct RawHeader {
    int rows = 0, columns = 0;
    bool big_endian = false, is_signed = true;
    std::uint64_t skip = 0;
    std::optional<double> no_data = {};
};
// Throws InvalidInput with the name, the line and the key, and Unsupported for other layouts.
RawHeader parseRawHeader(const std::string& text, const std::string& name);

struct RawHeights {
    int rows = 0, columns = 0;
    std::vector<double> numbers;  // NaN where the header says that there is nothing
};
// Throws IoError, InvalidInput and Unsupported.
RawHeights readRawHeights(const std::filesystem::path& path);

}  // namespace penumbra
