#pragma once
#include "formats/image/environment_map.h"

namespace penumbra {

// A latitude-longitude picture of a sky of one colour and a sun of one pixel.
inline EnvironmentMap pixelSun(float sun, Vec3 sky, int height = 64) {
    Image image{2 * height, height, std::vector<Vec3>(std::size_t(2 * height * height), sky), {}};
    image.pixels[std::size_t(2 * height * (height / 3) + 17)] = {sun, sun, sun};
    return makeEnvironmentMap(std::move(image), "latlong", "sun.exr");
}

}  // namespace penumbra
