#pragma once
// The light at a character, from pictures that look around.
#include <span>

#include "formats/capture/posed_picture.h"

namespace penumbra {

struct RoamPanoramaOptions {
    Vec3d at;         // where the light is wanted, metres of the marker's frame, z > 0
    int width = 512;  // pixels of the panorama
    int samples = 3;  // a pixel and axis
    int threads = 0;
    Ground ground = Ground::kLevel;
};
// Every direction gets the mean of the pictures that show it. A picture weighs more the nearer to its middle it shows
// the direction, and hardly anything where it is clipped and another one is not. Directions that go down see the ground
// z = 0; what lies higher counts as far away.
Panorama panoramaOfPictures(std::span<const PosedPicture> shots, const RoamPanoramaOptions& options);

}  // namespace penumbra
