#pragma once
// Reads and writes picture formats on bytes in memory; each source file (image_exr.cpp, image_hdr.cpp, image_png.cpp)
// has one format. Only image_*.cpp include this. `name` starts the message of every InvalidInput and Unsupported.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/image/image_file.h"

namespace penumbra {

constexpr int kMaxImageSide = 32768;

bool looksLikeExr(std::span<const std::byte> bytes);
Image decodeExr(std::span<const std::byte> bytes, const std::string& name);
std::vector<std::byte> encodeExr(const Image& image);

bool looksLikeHdr(std::span<const std::byte> bytes);
Image decodeHdr(std::span<const std::byte> bytes, const std::string& name);

std::vector<std::byte> encodePng(const Image& image, float exposure);

}  // namespace penumbra
