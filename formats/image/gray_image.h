#pragma once
// Pictures of one channel as the numbers that they hold, for heights. picture_kinds.h reads them.
#include <cstddef>
#include <string>
#include <vector>

namespace penumbra {

struct GrayImage {
    int width = 0, height = 0;
    std::vector<float> numbers;  // [height, width], as stored: 0..255 or 0..65535 of PNG, also NaN and infinity of EXR
};

// Which channel of a picture of several is wanted ("": the only one, or R, else Y, else Z), and how long a side may be.
struct GrayChoice {
    std::string channel;
    int most = 0;
};

}  // namespace penumbra
