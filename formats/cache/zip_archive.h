#pragma once
// Reads members of a zip archive, stored or deflated, with zip64 (PKWARE APPNOTE 6.3), as NumPy's savez writes them.
#include <optional>
#include <string>
#include <vector>

#include "formats/common/random_bytes.h"

namespace penumbra {

struct ZipMember {
    std::string name;
    int method = 0;  // 0 stored, 8 deflated
    bool encrypted = false;
    std::uint32_t crc = 0;
    std::uint64_t packed_size = 0, size = 0, local_header = 0;
};

struct ZipArchive {
    std::string file;  // for messages
    RandomBytes bytes;
    std::vector<ZipMember> members;  // in the order of the central directory
};

// Opens an archive. Throws InvalidInput where the file is no archive, is cut short or damaged.
ZipArchive openZip(const std::filesystem::path& path);

// Checks size and checksum by reading the member once. Returns nothing where no member has that name. Throws
// InvalidInput, and Unsupported where the member is encrypted or packed by another method.
std::optional<RandomBytes> openMember(const ZipArchive& zip, const std::string& name);

}  // namespace penumbra
