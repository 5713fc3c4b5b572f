#include "formats/stage/hdf5_text.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <vector>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::array<char, 5> kSignature{'G', 'C', 'O', 'L', 1};  // and the version
constexpr std::size_t kHeaderBytes = 16;  // of a heap (signature, version, size) and of an object (index, uses, size)
constexpr std::size_t kSmallestHeap = 4096;

// HDF5 rounds the buffer that an object is read into up to this; larger objects overrun it when a reference to them
// gives too small a length.
constexpr std::uint64_t kSafeBytes = 4096;

template <class T>
T valueAt(std::span<const std::byte> bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);  // little endian, as every HDF5 file is
    return value;
}

std::size_t find(std::span<const std::byte> bytes, std::size_t from, const void* pattern, std::size_t size) {
    const void* found = ::memmem(bytes.data() + from, bytes.size() - from, pattern, size);
    return found ? std::size_t(static_cast<const std::byte*>(found) - bytes.data()) : bytes.size();
}

// The list of files of a virtual dataset is an object, too; its layout message (version 4, class 3) gives the address
// and the index right after these two bytes, and no length. A text whose reference looks like this claims more than
// 48 MiB: too little only for an object larger than that.
bool isVirtualLayout(std::span<const std::byte> file, std::size_t at, std::uint64_t size) {
    return file[at - 2] == std::byte(4) && file[at - 1] == std::byte(3) && size < (std::uint64_t(0x0304) << 16);
}

// A reference is the length (4 bytes), the heap's address (8) and the object's index (4).
void checkReferences(std::span<const std::byte> file, std::uint64_t heap, std::uint32_t index, std::uint64_t size,
                     const std::string& name) {
    std::array<std::byte, 12> target;
    std::memcpy(target.data(), &heap, 8);
    std::memcpy(target.data() + 8, &index, 4);
    for (std::size_t at = find(file, 4, target.data(), 12); at < file.size();
         at = find(file, at + 1, target.data(), 12))
        if (valueAt<std::uint32_t>(file, at - 4) != size && !isVirtualLayout(file, at, size))
            throw InvalidInput(name + ": damaged (length of a text)");
}

void checkHeap(std::span<const std::byte> bytes, std::span<const std::byte> file, std::uint64_t heap,
               const std::string& name) {
    const InvalidInput damaged(name + ": damaged (global heap)");
    for (std::size_t at = kHeaderBytes; bytes.size() - at >= kHeaderBytes;) {
        const std::uint16_t index = valueAt<std::uint16_t>(bytes, at);
        const std::uint64_t size = valueAt<std::uint64_t>(bytes, at + 8), rest = bytes.size() - at;
        if (size > rest) throw damaged;
        // Object 0 is the free space at the end, its own header included.
        const std::uint64_t taken = index == 0 ? size : kHeaderBytes + (size + 7) / 8 * 8;
        if (taken < kHeaderBytes || taken > rest) throw damaged;
        if (index != 0 && size > kSafeBytes) checkReferences(file, heap, index, size, name);
        at += taken;
    }
}

}  // namespace

void checkGlobalHeaps(std::span<const std::byte> file, const std::string& name) {
    for (std::size_t at = find(file, 0, kSignature.data(), kSignature.size()); at < file.size();
         at = find(file, at + 1, kSignature.data(), kSignature.size())) {
        // HDF5 refuses heaps of other sizes; this also sorts out chance occurrences in stored numbers.
        if (file.size() - at < kSmallestHeap) return;
        const std::uint64_t size = valueAt<std::uint64_t>(file, at + 8);
        if (size >= kSmallestHeap && size <= file.size() - at) checkHeap(file.subspan(at, size), file, at, name);
    }
}

namespace {

// The bytes [address, address + size) of the file, or InvalidInput.
std::span<const std::byte> part(std::span<const std::byte> file, std::uint64_t address, std::uint64_t size,
                                const std::string& name) {
    if (address > file.size() || size > file.size() - address) throw InvalidInput(name + ": damaged");
    return file.subspan(address, size);
}

}  // namespace

std::string textOfReference(std::span<const std::byte> file, std::uint64_t address, const std::string& name) {
    const std::span<const std::byte> reference = part(file, address, kTextReferenceBytes, name);
    const std::uint32_t length = valueAt<std::uint32_t>(reference, 0), wanted = valueAt<std::uint32_t>(reference, 12);
    if (length == 0) return "";
    const std::uint64_t heap = valueAt<std::uint64_t>(reference, 4);
    const std::span<const std::byte> header = part(file, heap, kHeaderBytes, name);
    if (std::memcmp(header.data(), kSignature.data(), kSignature.size()) != 0) throw InvalidInput(name + ": damaged");
    const std::span<const std::byte> bytes = part(file, heap, valueAt<std::uint64_t>(header, 8), name);
    for (std::size_t at = kHeaderBytes; bytes.size() >= kHeaderBytes && bytes.size() - at >= kHeaderBytes;) {
        const std::uint16_t index = valueAt<std::uint16_t>(bytes, at);
        const std::uint64_t size = valueAt<std::uint64_t>(bytes, at + 8);
        if (index == 0 || size > bytes.size() - at - kHeaderBytes) break;
        const char* text = reinterpret_cast<const char*>(bytes.data() + at + kHeaderBytes);
        if (index == wanted && size == length) return std::string(text, ::strnlen(text, size));
        at += kHeaderBytes + std::min<std::uint64_t>((size + 7) / 8 * 8, bytes.size() - at - kHeaderBytes);
    }
    throw InvalidInput(name + ": damaged");
}

// --- Object headers of version 1 ------------------------------------------------------------------------------------

namespace {

// The value inside of an attribute message: header, name, type, shape, value; padded to 8 bytes each in version 1.
std::optional<std::size_t> valueInMessage(std::span<const std::byte> message, std::string_view attribute) {
    if (message.size() < 9) return std::nullopt;
    const int version = int(message[0]);
    if (version < 1 || version > 3) return std::nullopt;
    std::size_t at = version == 3 ? 9 : 8;
    const std::size_t name_at = at;
    for (std::size_t field : {2, 4, 6}) {
        const std::size_t size = valueAt<std::uint16_t>(message, field);
        at += version == 1 ? (size + 7) / 8 * 8 : size;
    }
    const std::size_t name_size = valueAt<std::uint16_t>(message, 2);
    if (at + kTextReferenceBytes > message.size() || name_size != attribute.size() + 1) return std::nullopt;
    if (std::memcmp(message.data() + name_at, attribute.data(), attribute.size()) != 0) return std::nullopt;
    return at;
}

}  // namespace

std::optional<std::uint64_t> uncheckedAttribute(std::span<const std::byte> file, std::uint64_t object,
                                                const std::string& attribute, const std::string& name) {
    constexpr std::size_t kPrefix = 16, kMessageHeader = 8;
    constexpr std::uint16_t kAttributeMessage = 0x0c, kContinuation = 0x10;
    const std::span<const std::byte> prefix = part(file, object, kPrefix, name);
    if (int(prefix[0]) != 1) return std::nullopt;
    struct Chunk {
        std::uint64_t address, size;
    };
    std::vector<Chunk> chunks{{object + kPrefix, valueAt<std::uint32_t>(prefix, 8)}};
    for (std::size_t c = 0; c < chunks.size() && c < 1000; ++c) {
        const std::span<const std::byte> chunk = part(file, chunks[c].address, chunks[c].size, name);
        for (std::size_t at = 0; chunk.size() - at >= kMessageHeader;) {
            const std::uint16_t type = valueAt<std::uint16_t>(chunk, at), size = valueAt<std::uint16_t>(chunk, at + 2);
            at += kMessageHeader;
            if (size > chunk.size() - at) throw InvalidInput(name + ": damaged");
            const std::span<const std::byte> message = chunk.subspan(at, size);
            if (type == kContinuation && size >= 16)
                chunks.push_back({valueAt<std::uint64_t>(message, 0), valueAt<std::uint64_t>(message, 8)});
            if (type == kAttributeMessage)
                if (const auto value = valueInMessage(message, attribute)) return chunks[c].address + at + *value;
            at += size;
        }
    }
    throw InvalidInput(name + ": damaged");
}

}  // namespace penumbra
