#pragma once
#include <filesystem>

#include "formats/image_file.h"

namespace penumbra {

// What was drawn into the current framebuffer's lower left width x height pixels, as it is displayed: linear values
// that a PNG of exposure 1 encodes into the same bytes.
Image readDisplayed(int width, int height);

// FOLDER/view_0001.png, or with the first number above it that is free.
std::filesystem::path freeScreenshotName(const std::filesystem::path& folder);

}  // namespace penumbra
