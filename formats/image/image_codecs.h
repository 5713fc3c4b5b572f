#pragma once
// Reads and writes picture formats on bytes; each source file (image_exr.cpp, image_hdr.cpp, image_png.cpp,
// image_png_read.cpp, image_gray_png.cpp, image_jpeg.cpp) has one format. Only these, texture_file.cpp and
// picture_kinds.cpp, which say what is read as what, include this. `name` starts the message of every InvalidInput and
// Unsupported.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/image/gray_image.h"
#include "formats/image/image_file.h"
#include "formats/image/picture_rows.h"
#include "formats/image/texture_file.h"

namespace penumbra {

constexpr int kMaxImageSide = 32768;

bool looksLikeExr(std::span<const std::byte> bytes);
std::unique_ptr<PictureRows> openExr(const RandomBytes& bytes, const std::string& name, const PictureOptions& options);
GrayImage decodeExrChannel(std::span<const std::byte> bytes, const std::string& name, const GrayChoice& choice);
std::vector<std::byte> encodeExr(const Image& image);

bool looksLikeHdr(std::span<const std::byte> bytes);
std::unique_ptr<PictureRows> openHdr(const RandomBytes& bytes, const std::string& name, const PictureOptions& options);

std::vector<std::byte> encodePng(const Image& image, float exposure);

bool looksLikePng(std::span<const std::byte> bytes);
TexturePicture decodePng(std::span<const std::byte> bytes, const std::string& name);
GrayImage decodeGrayPng(std::span<const std::byte> bytes, const std::string& name, const GrayChoice& choice);

std::vector<std::byte> encodePng(const TexturePicture& picture);

bool looksLikeJpeg(std::span<const std::byte> bytes);
TexturePicture decodeJpeg(std::span<const std::byte> bytes, const std::string& name);

// Throws InvalidInput where a side is out of range, or where the file's bytes can hold only `most_pixels` and it claims
// more: memory is taken only for what may be there.
void checkTextureSize(std::uint64_t width, std::uint64_t height, std::uint64_t most_pixels, const std::string& name);

// Returns the bytes of a plain file. Throws IoError.
std::vector<std::byte> readImageBytes(const std::filesystem::path& path);

}  // namespace penumbra
