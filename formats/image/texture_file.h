#pragma once
// Reads the pictures that colour a surface: PNG and JPEG files, as they lie beside a rig or inside it.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

// A picture as its file stores it: 8 bits a channel, which stand for sRGB. Gamma and colour profiles are left out, as
// glTF 2.0 asks (section 3.8).
struct TexturePicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;         // [height, width, 3], row 0 at the top
    std::vector<std::uint8_t> alpha = {};  // [height, width]; empty: the file has none, and all is opaque
};

constexpr int kMaxTextureSide = 16384;

// Decodes the bytes of a file, whose kind its first bytes tell; `name` starts every message. Throws Unsupported for
// other kinds of pictures, and InvalidInput for damaged ones and for a side above kMaxTextureSide.
TexturePicture decodeTexture(std::span<const std::byte> bytes, const std::string& name);
// Does the same with a file. Throws IoError where it cannot be read.
TexturePicture readTexture(const std::filesystem::path& path, const std::string& name);

// Writes the codes as a PNG of 8 bits a channel, whole or not at all, and fast rather than small. Throws IoError.
void writeTexturePng(const std::filesystem::path& path, const TexturePicture& picture);

}  // namespace penumbra
