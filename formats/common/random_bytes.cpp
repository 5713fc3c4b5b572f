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
    int descriptor = -1;

    ~OpenFile() {
        if (descriptor >= 0) ::close(descriptor);
    }
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
    const auto file = std::make_shared<OpenFile>();
    file->path = path;
    file->descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file->descriptor < 0) file->fail(std::string("cannot read: ") + std::strerror(errno));
    const off_t size = ::lseek(file->descriptor, 0, SEEK_END);
    if (size < 0) file->fail(std::string("cannot read: ") + std::strerror(errno));
    return {std::uint64_t(size),
            [file](std::uint64_t offset, std::span<std::byte> out) { readAll(*file, offset, out); }};
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
