#pragma once
#include <vector>

namespace penumbra {

constexpr int kMaxLightPicture = 4096;  // pixels across

// A light as a lat-long picture without its suns.
struct LightPicture {
    int width = 0, height = 0;  // width = 2 height; 0: none
    std::vector<float> pixels;  // [height, width, 3], row 0 at +y, >= 0 and within the range of half floats
};

}  // namespace penumbra
