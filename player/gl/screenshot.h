#pragma once
#include <filesystem>

#include "formats/image/image_file.h"

namespace penumbra {

// Reads a part of the current framebuffer as it is displayed; (x, y) is its lower left pixel. The linear values
// become the same bytes again when a PNG of exposure 1 encodes them.
Image readDisplayed(int x, int y, int width, int height);

// Returns FOLDER/view_0001.png, or the name with the first number above it that is free.
std::filesystem::path freeScreenshotName(const std::filesystem::path& folder);
// Returns FOLDER/turn_0001.y4m, or the name with the first number above it that is free.
std::filesystem::path freeTurntableName(const std::filesystem::path& folder);
// Returns FOLDER/CLIP_0012.png. Characters of the clip's name that no file name should have become '_'.
std::filesystem::path sequenceName(const std::filesystem::path& folder, std::string_view clip, std::size_t frame);

}  // namespace penumbra
