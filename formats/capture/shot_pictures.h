#pragma once
// Reads the photographs of a capture, and tells those that cannot belong together.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/image/texture_file.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

// Returns the pictures in their order. Throws IoError, and InvalidInput for one whose size is not the camera's.
std::vector<TexturePicture> readShotPictures(std::span<const std::filesystem::path> files, const PinholeCamera& camera,
                                             int threads);

// Pictures of one view with several exposures.
struct ExposureSet {
    std::span<const TexturePicture> pictures;
    std::span<const double> exposures;             // [pictures]
    std::span<const std::filesystem::path> files;  // [pictures]
};
// Empty, or one sentence on what cannot be: two pictures have the same exposure, a longer exposure is darker than a
// shorter one, or all pictures are clipped everywhere, or black everywhere.
std::string findProblem(const ExposureSet& set);
// The same where one place is looked at in many directions: a part of them may show a white wall or a black night, and
// only the exposures must be right.
std::string findExposureProblem(const ExposureSet& set);
// Empty, or one sentence where all pictures are clipped everywhere or black everywhere.
std::string findDarkness(std::span<const TexturePicture> pictures);

}  // namespace penumbra
