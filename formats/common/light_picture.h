#pragma once
#include <vector>

namespace penumbra {

constexpr int kMaxLightPicture = 4096;  // pixels across

// The largest radiance of a light, and the largest number that is stored of one: an SH coefficient is at most sqrt(4
// pi) times the radiance, an irradiance 4 pi times. Floats end at 3.4e38. What lies between is for the sums of shading,
// over coefficients, lobes and suns; the first of these sums to overflow does so at coefficients of 1e38.
constexpr double kMaxRadiance = 1e30, kMaxLightNumber = 1e33;

// A light as a lat-long picture without its suns.
struct LightPicture {
    int width = 0, height = 0;  // width = 2 height; 0: none
    std::vector<float> pixels;  // [height, width, 3], row 0 at +y, >= 0 and within the range of half floats
};

}  // namespace penumbra
