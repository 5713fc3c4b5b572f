#pragma once
// Bytes that any number of threads may read at any place: a file, a part of one, or a member of a zip archive.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace penumbra {

struct RandomBytes {
    std::uint64_t size = 0;
    // Fills `out` from `offset`; offset + out.size() <= size. Throws IoError where the file has become shorter.
    std::function<void(std::uint64_t offset, std::span<std::byte> out)> read;
};

// throws IoError; the file stays open as long as `read` lives
RandomBytes openBytes(const std::filesystem::path& path);
// The first `size` bytes of a file that is open already; the descriptor is closed with the last copy of `read`. `path`
// is for messages.
RandomBytes bytesOf(int descriptor, std::uint64_t size, const std::filesystem::path& path);
RandomBytes partOf(const RandomBytes& bytes, std::uint64_t offset, std::uint64_t size);  // must lie within bytes.size
std::vector<std::byte> readBytes(const RandomBytes& bytes, std::uint64_t offset, std::size_t size);

}  // namespace penumbra
