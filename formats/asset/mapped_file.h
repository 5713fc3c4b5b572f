#pragma once
// A file as memory. It stands apart from the readers, because a browser has no files, and other systems map them in
// other ways.
#include <cstddef>
#include <span>
#include <string>

namespace penumbra {

// A read-only memory map that lives as long as the object. Throws IoError, and Unsupported where
// there are no files (mapped_file_none.cpp).
class MappedFile {
public:
    explicit MappedFile(const std::string& path);
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    std::span<const std::byte> bytes() const;

private:
    void* address_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace penumbra
