#pragma once
// Reads the text model of COLMAP (cameras.txt and images.txt of one folder), where structure from motion says where
// pictures were taken: https://colmap.github.io/format.html. Its frame has any place, turn and scale.
#include <filesystem>
#include <string>

#include "formats/camera/camera_file.h"

namespace penumbra {

// Returns the images in the natural order of their names (natural_order.h), with the camera that took them all.
// COLMAP's pixels have their corner at 0, ours have their center there. Models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL
// and RADIAL; throws Unsupported by name for others, for fx and fy that differ by more than 0.2%, and for images of
// more than one camera. Throws IoError, and InvalidInput with the file and the line.
CameraTrack readColmapModel(const std::filesystem::path& folder);
// The same for the two texts; `folder` stands in messages.
CameraTrack parseColmapModel(const std::string& cameras, const std::string& images, const std::string& folder);

}  // namespace penumbra
