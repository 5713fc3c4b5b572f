// Stands for mapped_file.cpp where there are no files.
#include "formats/asset/mapped_file.h"
#include "formats/common/errors.h"

namespace penumbra {

MappedFile::MappedFile(const std::string& path) {
    throw Unsupported(path + ": this build of the library opens no files, only bytes in memory");
}

MappedFile::~MappedFile() = default;

std::span<const std::byte> MappedFile::bytes() const { return {static_cast<const std::byte*>(address_), size_}; }

}  // namespace penumbra
