#pragma once
// A glTF file that is only added to: what it says stays, in its order, with all that nobody here knows.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

struct GrowingGlb {
    std::filesystem::path path;         // for messages
    nlohmann::ordered_json document;    // its JSON, with the keys in the file's order
    std::vector<unsigned char> binary;  // the bytes of buffer 0: those of the file, and behind them what was added
    std::vector<unsigned char> chunks;  // chunks behind the binary one, as they stand
    std::vector<std::filesystem::path> files_read;
    std::vector<std::string> notes;  // further changes that were necessary, one line each
};

// Reads a .glb, whose JSON and binary chunk stay as they are, or a .gltf. Buffers and pictures in other files are taken
// into the binary chunk, so that the result is one file; a note says so. Throws IoError and InvalidInput.
GrowingGlb openGrowingGlb(const std::filesystem::path& path);

// The use of an accessor: a vertex attribute; the times of keys, which need their range; or the values of keys.
enum class AccessorUse : std::uint8_t { kVertices, kTimes, kValues };

// Adds an accessor of floats with 1 to 4 `components` an element, and returns its index.
std::size_t addAccessor(GrowingGlb& glb, std::span<const float> numbers, int components, AccessorUse use);
// Adds an accessor of zeros, which takes no bytes of the binary chunk.
std::size_t addZeros(GrowingGlb& glb, std::size_t count, int components);

// Adds a buffer view of any bytes, and returns its index.
std::size_t addBytes(GrowingGlb& glb, std::span<const std::byte> bytes);

// Returns the bytes of the .glb. Throws Unsupported above the 4 GiB that the format allows.
std::vector<std::byte> bytesOf(const GrowingGlb& glb);

}  // namespace penumbra
