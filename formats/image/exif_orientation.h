#pragma once
// Whether a camera noted that a picture is turned (EXIF 2.3, tag 0x0112), which readers of pictures here leave out.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace penumbra {

// Returns 1..8 as the bytes of a JPEG file say, of which the first 64 KiB are enough; 1, which is not turned, where
// they say nothing or are damaged.
int exifOrientation(std::span<const std::byte> jpeg);

// Empty, or a sentence that names the first of these files that is turned, and by which value. A file that cannot be
// read is passed over.
std::string findTurned(std::span<const std::filesystem::path> files);

}  // namespace penumbra
