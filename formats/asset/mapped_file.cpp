#include "formats/asset/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "formats/common/errors.h"

namespace penumbra {

MappedFile::MappedFile(const std::string& path) {
    const auto fail = [&](const char* what) {
        return IoError(path + ": cannot " + what + ": " + std::strerror(errno));
    };
    // The open does not block: to open a pipe would wait for its writer.
    const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) throw fail("open");
    struct stat status {};
    if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(file);
        throw IoError(path + ": not a regular file");
    }
    size_ = std::size_t(status.st_size);
    if (size_ > 0) {
        address_ = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
        if (address_ == MAP_FAILED) {
            const IoError error = fail("map");
            ::close(file);
            throw error;
        }
    }
    ::close(file);
}

MappedFile::~MappedFile() {
    if (size_ > 0) ::munmap(address_, size_);
}

std::span<const std::byte> MappedFile::bytes() const { return {static_cast<const std::byte*>(address_), size_}; }

}  // namespace penumbra
