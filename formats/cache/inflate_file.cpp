#include "formats/cache/inflate_file.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kBlock = std::size_t(1) << 18;
constexpr int kRawDeflate = -15;

struct Inflater {
    z_stream z{};

    Inflater() {
        if (inflateInit2(&z, kRawDeflate) != Z_OK) throw std::bad_alloc();
    }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() { inflateEnd(&z); }
};

// A file without a name, and what to say when it cannot be written.
struct Scratch {
    std::filesystem::path folder;
    std::string what;
    int descriptor = -1;

    [[noreturn]] void fail(const std::string& why) const {
        throw IoError(what + ": cannot be inflated into " + folder.string() + " (TMPDIR names another folder): " + why);
    }
    void open() {
        std::string name = (folder / "penumbra.XXXXXX").string();
        descriptor = ::mkostemp(name.data(), O_CLOEXEC);
        if (descriptor < 0) fail(std::strerror(errno));
        ::unlink(name.c_str());
    }
    void write(std::span<const std::byte> bytes) const {
        while (!bytes.empty()) {
            const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
            if (written < 0 && errno != EINTR) fail(std::strerror(errno));
            bytes = bytes.subspan(std::size_t(std::max<ssize_t>(written, 0)));
        }
    }
};

Bytef* asZlib(std::byte* bytes) { return reinterpret_cast<Bytef*>(bytes); }

// Writes what `packed` inflates to; returns its size and CRC-32.
std::pair<std::uint64_t, uLong> inflateInto(const Scratch& file, const RandomBytes& packed, std::uint64_t most) {
    Inflater inflater;
    std::vector<std::byte> input(kBlock), output(kBlock);
    std::uint64_t consumed = 0, produced = 0;
    uLong sum = crc32(0, nullptr, 0);
    for (int result = Z_OK; result != Z_STREAM_END;) {
        throwIfInterrupted();
        const auto part = std::span(input).first(std::size_t(std::min<std::uint64_t>(kBlock, packed.size - consumed)));
        packed.read(consumed, part);
        inflater.z.next_in = asZlib(part.data());
        inflater.z.avail_in = uInt(part.size());
        inflater.z.next_out = asZlib(output.data());
        inflater.z.avail_out = uInt(output.size());
        result = inflate(&inflater.z, Z_NO_FLUSH);
        if (result == Z_MEM_ERROR) throw std::bad_alloc();
        // Without input left, zlib says Z_BUF_ERROR where it cannot go on.
        if (result != Z_OK && result != Z_STREAM_END)
            throw InvalidInput(file.what + ": its compressed data are damaged");
        consumed += part.size() - inflater.z.avail_in;
        const auto got = std::span(output).first(kBlock - inflater.z.avail_out);
        produced += got.size();
        if (produced > most) throw InvalidInput(file.what + ": its data are longer than stated");
        sum = crc32(sum, asZlib(got.data()), uInt(got.size()));
        file.write(got);
    }
    if (consumed != packed.size) throw InvalidInput(file.what + ": bytes follow the end of its compressed data");
    return {produced, sum};
}

// Returns the folder for temporary files that may be large. /tmp is in memory on many systems.
std::filesystem::path scratchFolder() {
    const char* const chosen = std::getenv("TMPDIR");
    return chosen && *chosen ? chosen : "/var/tmp";
}

}  // namespace

RandomBytes inflateToFile(const RandomBytes& packed, std::uint64_t size, std::uint32_t crc, const std::string& what) {
    std::error_code unknown;
    Scratch file{scratchFolder(), what};
    // Ask for the room before anything is written; what is unknown is found out by writing.
    const std::filesystem::space_info room = std::filesystem::space(file.folder, unknown);
    if (!unknown && room.available < size)
        file.fail("it needs " + std::to_string(size >> 10) + " KB, and " + std::to_string(room.available >> 10) +
                  " KB are free");
    file.open();
    const RandomBytes bytes = bytesOf(file.descriptor, size, what);
    const auto [produced, sum] = inflateInto(file, packed, size);
    if (produced != size) throw InvalidInput(what + ": its data are shorter than stated");
    if (sum != crc) throw InvalidInput(what + ": its checksum is wrong");
    return bytes;
}

}  // namespace penumbra
