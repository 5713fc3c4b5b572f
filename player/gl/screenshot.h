#pragma once
#include <filesystem>

#include "formats/image/image_file.h"

namespace penumbra {

// A part of the current framebuffer, (x, y) its lower left pixel, as it is displayed: linear values that a PNG of
// exposure 1 encodes into the same bytes.
Image readDisplayed(int x, int y, int width, int height);

// FOLDER/view_0001.png, or with the first number above it that is free.
std::filesystem::path freeScreenshotName(const std::filesystem::path& folder);
// FOLDER/CLIP_0012.png; what a file name should not have in it is a '_' of the clip's name.
std::filesystem::path sequenceName(const std::filesystem::path& folder, std::string_view clip, std::size_t frame);

}  // namespace penumbra
