#pragma once
// A picture of radiance with the camera that took it, and what it shows in a direction.
#include <functional>
#include <optional>

#include "formats/capture/merge_exposures.h"
#include "formats/capture/panorama.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

struct PosedPicture {
    RadiancePicture picture;
    PinholeCamera camera;  // has the picture's size
    CameraPose pose;
};

// Where a place of the marker's frame, or a ray from the camera, appears. None outside of the picture.
std::optional<PixelPoint> pixelOfPlace(const PosedPicture& shot, Vec3d place);
std::optional<PixelPoint> pixelOfRay(const PosedPicture& shot, Vec3d ray);

// Returns the picture's light at a pixel, with bilinear interpolation and weight 1.
SeenLight lightAt(const RadiancePicture& picture, PixelPoint pixel);

// Returns where a ray from `from` in this unit direction meets a level ground z = 0. None where it goes up or level,
// and without a ground.
std::optional<Vec3d> groundBelow(Ground ground, Vec3d from, Vec3d direction);

// Paints a panorama of this width: every pixel is the mean of what `look` sees in samples^2 directions, unit vectors of
// the marker's frame. Samples between the pixels of the photographs keep the energy of small suns. `look` is called by
// several threads.
Panorama paintPanorama(int width, int samples, int threads, const std::function<SeenLight(Vec3d)>& look);

}  // namespace penumbra
