#pragma once
// Makes the picture of a light that is seen from far away. It uses no GL.
#include <array>
#include <cstdint>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/image/environment_map.h"

namespace penumbra {

// A lat-long picture of radiance (formats/image/image_file.h has its directions), without suns.
struct SkyPicture {
    int width = 0, height = 0;
    std::vector<std::array<std::uint16_t, 4>> texels;  // [height, width] half-float RGB and 0
    std::vector<Sun> suns;                             // suns that the picture lacks
};

// Returns the light's own picture with its suns, or, for a light that has none, its SH with ringing below 0 as 0.
SkyPicture skyPicture(const LightView& light);

// Returns the picture of a light as it is, at most 2048 wide, with the suns that are in it.
SkyPicture skyPicture(const EnvironmentMap& map);

}  // namespace penumbra
