#pragma once
// Compares two pictures of one frame as they are displayed.

#include "formats/image/image_file.h"

namespace penumbra {

struct ImageError {
    std::size_t pixels = 0;       // pixels that both pictures cover entirely
    double squares = 0;           // sum over them of the squared differences of the three 8-bit colours
    double flip_sum = 0;          // sum of FLIP over the pixels that either covers at all, both over the same grey
    std::size_t flip_pixels = 0;  // 0: not measured

    void add(const ImageError& other);
    double rmse() const;  // steps of 8 bits, 0..255; NaN where no pixel is covered
    double flip() const;  // mean; NaN where it was not measured
};

enum class ImageMetrics { kRmse, kRmseAndFlip };  // FLIP takes most of the time
// Compares what a PNG of this exposure would store. Both pictures have alpha and the same size. A pixel that is NaN
// makes both errors NaN.
ImageError imageError(const Image& model, const Image& truth, float exposure, ImageMetrics metrics, int threads);

}  // namespace penumbra
