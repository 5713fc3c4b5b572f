#include "formats/common/random_bytes.h"

#include <fcntl.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <memory>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {
struct OpenFile {
    std::filesystem::path path;
    int descriptor;

    OpenFile(std::filesystem::path file, int opened) : path(std::move(file)), descriptor(opened) {}
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    ~OpenFile() { ::close(descriptor); }
    [[noreturn]] void fail(const std::string& what) const { throw IoError(path.string() + ": " + what); }
};

void readAll(const OpenFile& file, std::uint64_t offset, std::span<std::byte> out) {
    while (!out.empty()) {
        const ssize_t got = ::pread(file.descriptor, out.data(), out.size(), off_t(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) file.fail(std::string("cannot read: ") + std::strerror(errno));
        if (got == 0) file.fail("became shorter while it was read");
        offset += std::uint64_t(got);
        out = out.subspan(std::size_t(got));
    }
}

}  // namespace

RandomBytes openBytes(const std::filesystem::path& path) {
    checkReadable(path);
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const off_t size = descriptor < 0 ? -1 : ::lseek(descriptor, 0, SEEK_END);
    if (size < 0) {
        const std::string why = std::strerror(errno);
        if (descriptor >= 0) ::close(descriptor);
        throw IoError(path.string() + ": cannot read: " + why);
    }
    return bytesOf(descriptor, std::uint64_t(size), path);
}

RandomBytes bytesOf(int descriptor, std::uint64_t size, const std::filesystem::path& path) {
    const auto file = std::make_shared<const OpenFile>(path, descriptor);
    return {size, [file](std::uint64_t offset, std::span<std::byte> out) { readAll(*file, offset, out); }};
}

RandomBytes partOf(const RandomBytes& bytes, std::uint64_t offset, std::uint64_t size) {
    assert(offset <= bytes.size && size <= bytes.size - offset);
    return {size, [read = bytes.read, offset](std::uint64_t at, std::span<std::byte> out) { read(offset + at, out); }};
}

std::vector<std::byte> readBytes(const RandomBytes& bytes, std::uint64_t offset, std::size_t size) {
    std::vector<std::byte> out(size);
    bytes.read(offset, out);
    return out;
}

}  // namespace penumbra
