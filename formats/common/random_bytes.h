#pragma once
// Bytes that any number of threads read from any place: a file, a part of one, or a member of a zip archive.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace penumbra {

struct RandomBytes {
    std::uint64_t size = 0;
    // Fills `out` from `offset`; offset + out.size() <= size. IoError where the file is shorter than it was.
    std::function<void(std::uint64_t offset, std::span<std::byte> out)> read;
};

RandomBytes openBytes(const std::filesystem::path& path);  // IoError; the file stays open as long as `read` is there
RandomBytes partOf(const RandomBytes& bytes, std::uint64_t offset, std::uint64_t size);  // within bytes.size
std::vector<std::byte> readBytes(const RandomBytes& bytes, std::uint64_t offset, std::size_t size);

}  // namespace penumbra
