#include "formats/stage/hdf5_storage.h"

#include <cstring>
#include <string_view>
#include <vector>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr unsigned kExternalFiles = 0x07, kLayout = 0x08, kContinuation = 0x10;  // types of messages

// A part of an object header: a list of messages.
struct HeaderChunk {
    std::uint64_t address = 0, size = 0;
};

class HeaderBytes {
public:
    HeaderBytes(std::span<const std::byte> file, const std::string& name) : file_(file), name_(name) {}

    // The bytes [address, address + size) of the file, or InvalidInput.
    std::span<const std::byte> part(std::uint64_t address, std::uint64_t size) const {
        if (address > file_.size() || size > file_.size() - address) fail();
        return file_.subspan(address, size);
    }
    // Little endian, as every HDF5 file is.
    std::uint64_t number(std::uint64_t address, std::size_t size) const {
        std::uint64_t value = 0;
        std::memcpy(&value, part(address, size).data(), size);
        return value;
    }
    bool signature(std::uint64_t address, std::string_view text) const {
        return std::memcmp(part(address, text.size()).data(), text.data(), text.size()) == 0;
    }
    std::uint64_t fileSize() const { return file_.size(); }
    [[noreturn]] void fail() const { throw InvalidInput(name_ + ": damaged (object header)"); }

private:
    std::span<const std::byte> file_;
    const std::string& name_;
};

bool namesOtherFiles(unsigned type, std::span<const std::byte> message) {
    constexpr unsigned kVirtual = 3, kFirstVersionWithClass = 3;
    if (type == kExternalFiles) return true;
    return type == kLayout && message.size() >= 2 && unsigned(message[0]) >= kFirstVersionWithClass &&
           unsigned(message[1]) == kVirtual;
}

}  // namespace

bool storedElsewhere(std::span<const std::byte> file, std::uint64_t address, const std::string& name) {
    const HeaderBytes in(file, name);

    // 1. The first chunk. Headers of version 1 have no signature; those of version 2 have optional fields before it.
    const bool second = in.signature(address, "OHDR");
    std::vector<HeaderChunk> chunks;
    std::size_t message_header = 8;
    if (second) {
        const std::uint64_t flags = in.number(address + 5, 1);
        const std::uint64_t size_at = address + 6 + ((flags & 0x20) ? 16 : 0) + ((flags & 0x10) ? 4 : 0);
        const std::size_t size_bytes = std::size_t(1) << (flags & 3);
        chunks.push_back({size_at + size_bytes, in.number(size_at, size_bytes)});
        message_header = (flags & 0x04) ? 6 : 4;
    } else {
        chunks.push_back({address + 16, in.number(address + 8, 4)});
    }

    // 2. All messages. Chunks do not overlap: where they do, a file could make us read the same bytes for ever.
    std::uint64_t walked = 0;
    for (std::size_t c = 0; c < chunks.size(); ++c) {
        const HeaderChunk chunk = chunks[c];
        if (chunk.size > in.fileSize() - walked) in.fail();
        walked += chunk.size;
        (void)in.part(chunk.address, chunk.size);
        for (std::uint64_t at = 0; chunk.size - at >= message_header;) {
            const std::uint64_t start = chunk.address + at;
            const auto type = unsigned(in.number(start, second ? 1 : 2));
            const std::uint64_t size = in.number(start + (second ? 1 : 2), 2);
            at += message_header;
            if (size > chunk.size - at) in.fail();
            const std::span<const std::byte> message = in.part(chunk.address + at, size);
            if (namesOtherFiles(type, message)) return true;
            if (type == kContinuation && size >= 16) {
                HeaderChunk next{in.number(chunk.address + at, 8), in.number(chunk.address + at + 8, 8)};
                if (second) {  // a signature before the messages, a checksum behind them
                    if (next.size < 8) in.fail();
                    next = {next.address + 4, next.size - 8};
                }
                if (next.size > 0) chunks.push_back(next);
            }
            at += size;
        }
    }
    return false;
}

}  // namespace penumbra
