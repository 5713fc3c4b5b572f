#include "formats/cache/zip_archive.h"

#include <zlib.h>

#include <algorithm>

#include "formats/cache/inflate_file.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kLocalHeader = 0x04034b50, kDirectoryEntry = 0x02014b50, kDirectoryEnd = 0x06054b50,
                        kDirectoryEnd64 = 0x06064b50, kDirectoryLocator64 = 0x07064b50;
constexpr std::size_t kLocalHeaderSize = 30, kEntrySize = 46, kEndSize = 22, kEnd64Size = 56, kLocator64Size = 20;
constexpr std::uint64_t kMaxDirectorySize = std::uint64_t(1) << 26;
constexpr std::uint64_t kMaxRatio = 1032;  // deflate cannot pack more than 258 bytes into 2 bits

std::uint64_t number(std::span<const std::byte> bytes, std::size_t offset, std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | std::uint64_t(bytes[offset + i]);
    return value;
}

}  // namespace

[[noreturn]] static void fail(const std::string& file, const std::string& what) {
    throw InvalidInput(file + ": " + what);
}

namespace {
struct Directory {
    std::uint64_t offset = 0, size = 0;
};

void readEnd64(const std::string& file, const RandomBytes& bytes, std::uint64_t end, Directory& directory) {
    if (end < kLocator64Size) fail(file, "is not a whole zip archive");
    const auto locator = readBytes(bytes, end - kLocator64Size, kLocator64Size);
    if (number(locator, 0, 4) != kDirectoryLocator64) fail(file, "its zip64 directory is missing");
    const std::uint64_t at = number(locator, 8, 8);
    if (bytes.size < kEnd64Size || at > bytes.size - kEnd64Size) fail(file, "its zip64 directory is missing");
    const auto end64 = readBytes(bytes, at, kEnd64Size);
    if (number(end64, 0, 4) != kDirectoryEnd64) fail(file, "its zip64 directory is missing");
    directory = {number(end64, 48, 8), number(end64, 40, 8)};
}

// Finds the end record, which is the last thing in the file except for a comment of up to 65535 bytes.
Directory findDirectory(const std::string& file, const RandomBytes& bytes) {
    const std::size_t tail_size = std::size_t(std::min<std::uint64_t>(bytes.size, kEndSize + 65535));
    const auto tail = readBytes(bytes, bytes.size - tail_size, tail_size);
    for (std::size_t at = tail_size < kEndSize ? 0 : tail_size - kEndSize + 1; at-- > 0;) {
        if (number(tail, at, 4) != kDirectoryEnd || number(tail, at + 20, 2) != tail_size - kEndSize - at) continue;
        Directory directory{number(tail, at + 16, 4), number(tail, at + 12, 4)};
        if (directory.offset == 0xffffffff || directory.size == 0xffffffff || number(tail, at + 10, 2) == 0xffff)
            readEnd64(file, bytes, bytes.size - tail_size + at, directory);
        if (directory.offset > bytes.size || directory.size > bytes.size - directory.offset ||
            directory.size > kMaxDirectorySize)
            fail(file, "its zip directory is not in the file");
        return directory;
    }
    fail(file, "is not a zip archive, or cut short");
}

// Reads extra field 1, which has those of the three numbers that do not fit into 32 bits, in this order.
void readSizes64(const std::string& file, std::span<const std::byte> extra, ZipMember& member) {
    for (std::size_t at = 0; at + 4 <= extra.size();) {
        const std::size_t size = std::size_t(number(extra, at + 2, 2));
        if (number(extra, at, 2) != 1) {
            at += 4 + size;
            continue;
        }
        at += 4;
        for (std::uint64_t* value : {&member.size, &member.packed_size, &member.local_header}) {
            if (*value != 0xffffffff) continue;
            if (at + 8 > extra.size()) fail(file, "'" + member.name + "': its zip64 sizes are missing");
            *value = number(extra, at, 8);
            at += 8;
        }
        return;
    }
}

std::string printable(std::span<const std::byte> bytes) {
    std::string text;
    for (const std::byte b : bytes) text += std::uint8_t(b) < 32 ? '_' : char(b);
    return text;
}

}  // namespace

ZipArchive openZip(const std::filesystem::path& path) {
    ZipArchive zip{path.string(), openBytes(path), {}};
    const Directory place = findDirectory(zip.file, zip.bytes);
    const auto bytes = readBytes(zip.bytes, place.offset, std::size_t(place.size));
    const std::span<const std::byte> directory(bytes);
    for (std::size_t at = 0; at < directory.size();) {
        if (directory.size() - at < kEntrySize || number(directory, at, 4) != kDirectoryEntry)
            fail(zip.file, "its zip directory is damaged");
        const std::size_t name_size = std::size_t(number(directory, at + 28, 2));
        const std::size_t extra_size = std::size_t(number(directory, at + 30, 2));
        const std::size_t comment_size = std::size_t(number(directory, at + 32, 2));
        if (directory.size() - at - kEntrySize < name_size + extra_size + comment_size)
            fail(zip.file, "its zip directory is damaged");
        ZipMember member{.name = printable(directory.subspan(at + kEntrySize, name_size)),
                         .method = int(number(directory, at + 10, 2)),
                         .encrypted = (number(directory, at + 8, 2) & 1) != 0,
                         .crc = std::uint32_t(number(directory, at + 16, 4)),
                         .packed_size = number(directory, at + 20, 4),
                         .size = number(directory, at + 24, 4),
                         .local_header = number(directory, at + 42, 4)};
        readSizes64(zip.file, directory.subspan(at + kEntrySize + name_size, extra_size), member);
        zip.members.push_back(std::move(member));
        at += kEntrySize + name_size + extra_size + comment_size;
    }
    return zip;
}

namespace {

void checkStored(const RandomBytes& bytes, const ZipMember& member, const std::string& what) {
    if (member.packed_size != member.size) fail(what, "its two sizes differ although it is stored");
    std::vector<std::byte> block(std::size_t(1) << 18);
    uLong sum = crc32(0, nullptr, 0);
    for (std::uint64_t at = 0; at < bytes.size; at += block.size()) {
        const auto part = std::span(block).first(std::size_t(std::min<std::uint64_t>(block.size(), bytes.size - at)));
        bytes.read(at, part);
        sum = crc32(sum, reinterpret_cast<const Bytef*>(part.data()), uInt(part.size()));
    }
    if (sum != member.crc) fail(what, "its checksum is wrong");
}

}  // namespace

std::optional<RandomBytes> openMember(const ZipArchive& zip, const std::string& name) {
    const auto found =
        std::find_if(zip.members.begin(), zip.members.end(), [&](const ZipMember& m) { return m.name == name; });
    if (found == zip.members.end()) return std::nullopt;
    const std::string what = zip.file + ": '" + name + "'";
    if (found->encrypted) throw Unsupported(what + " is encrypted");
    if (found->method != 0 && found->method != 8)
        throw Unsupported(what + " is packed by method " + std::to_string(found->method) +
                          " (stored and deflated members are read)");
    const std::uint64_t start = found->local_header;
    if (start > zip.bytes.size || zip.bytes.size - start < kLocalHeaderSize) fail(what, "is not in the file");
    const auto header = readBytes(zip.bytes, start, kLocalHeaderSize);
    if (number(header, 0, 4) != kLocalHeader) fail(what, "its header is damaged");
    const std::uint64_t data = start + kLocalHeaderSize + number(header, 26, 2) + number(header, 28, 2);
    if (data > zip.bytes.size || found->packed_size > zip.bytes.size - data) fail(what, "is not whole in the file");
    const RandomBytes packed = partOf(zip.bytes, data, found->packed_size);
    if (found->method == 8) {
        if (found->size / kMaxRatio > found->packed_size) fail(what, "states more bytes than it can hold");
        return inflateToFile(packed, found->size, found->crc, what);
    }
    checkStored(packed, *found, what);
    return packed;
}

}  // namespace penumbra
