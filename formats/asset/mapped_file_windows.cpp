// Stands for mapped_file.cpp on Windows.
#include "formats/asset/mapped_file.h"

#define WIN32_LEAN_AND_MEAN
#ifndef NOMINMAX  // g++ has it already
#define NOMINMAX
#endif
#include <windows.h>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

// The path as Windows has it, or nothing where it is not UTF-8.
std::wstring wide(const std::string& path) {
    const int size = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path.data(), int(path.size()), nullptr, 0);
    std::wstring out(std::size_t(size), L'\0');
    MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path.data(), int(path.size()), out.data(), size);
    return out;
}

struct Handle {
    HANDLE handle;
    ~Handle() {
        if (handle && handle != INVALID_HANDLE_VALUE) CloseHandle(handle);
    }
};

}  // namespace

MappedFile::MappedFile(const std::string& path) {
    const auto fail = [&](const char* what) {
        return IoError(path + ": cannot " + what + ": error " + std::to_string(GetLastError()) + " of Windows");
    };
    // Others may replace the file by a rename meanwhile, as elsewhere.
    const Handle file{CreateFileW(wide(path).c_str(), GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_DELETE, nullptr,
                                  OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr)};
    if (file.handle == INVALID_HANDLE_VALUE) throw fail("open");
    LARGE_INTEGER size;
    if (GetFileType(file.handle) != FILE_TYPE_DISK || !GetFileSizeEx(file.handle, &size))
        throw IoError(path + ": not a regular file");
    size_ = std::size_t(size.QuadPart);
    if (size_ == 0) return;
    // The view keeps the mapping, and the mapping the file.
    const Handle mapping{CreateFileMappingW(file.handle, nullptr, PAGE_READONLY, 0, 0, nullptr)};
    if (mapping.handle) address_ = MapViewOfFile(mapping.handle, FILE_MAP_READ, 0, 0, 0);
    if (!address_) throw fail("map");
}

MappedFile::~MappedFile() {
    if (address_) UnmapViewOfFile(address_);
}

std::span<const std::byte> MappedFile::bytes() const { return {static_cast<const std::byte*>(address_), size_}; }

}  // namespace penumbra
