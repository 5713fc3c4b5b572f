#pragma once
// Suns in pictures: how large a sun is, and what the picture is without it.
#include "formats/common/light_picture.h"
#include "formats/image/environment_map.h"
#include "sh/light/analytic_light.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

struct SunDisc {
    Vec3d direction;              // center of the light in the disc
    double radius = 0;            // radians
    std::size_t flat_pixels = 0;  // pixels that have exactly the luminance of the brightest one
};
// Measures the sun near a direction. What is within 35 degrees loses its median, or where that is above half of the
// brightest pixel, the value that a tenth lies below; e is the flux of the pixels above 5% of the peak that is left. A
// disc of the peak's radiance with the flux sum e has cos radius = 1 - sum e / (2 pi peak). A picture that was clipped
// has a peak that is too low: its sun is too large, and many pixels are flat. The radius is 35 degrees where that
// tenth is above half of the brightest pixel, too, and 0 where all is black.
SunDisc measureSun(const EnvironmentMap& map, Vec3d near);
constexpr std::size_t kClippedPixels = 4;  // from this many flat pixels on a picture may have been clipped

// Removes a sun from a picture: within 35 degrees of its direction every channel is clamped to the level that takes
// exactly the sun's irradiance away. Of a sun that faded (share < 1) the rest stays. Where the surroundings have less
// light than that, they become black and the sun's irradiance becomes what they had.
void removeSun(EnvironmentMap& map, SunD& sun);

// Returns the picture as lat-long of this width, filtered by boxes of solid angle: it has the same flux. `clamped`
// becomes the part of the flux that does not fit half floats.
LightPicture smallPicture(const EnvironmentMap& map, int width, double& clamped);

// Paints lights as a lat-long picture. A directional light is one pixel with its flux.
EnvironmentMap paintLights(const LightParts& parts, int width);

}  // namespace penumbra
