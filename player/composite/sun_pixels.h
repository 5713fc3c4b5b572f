#pragma once
// The light of a sun at the ground points of all pixels of a picture.
#include <span>
#include <vector>

#include "runtime/sun/sun_map.h"

namespace penumbra {

// Points of the ground that pixels see. Rows are `stride` points apart and reach at least to a multiple of 2.
struct PixelPoints {
    int width = 0, height = 0;
    std::size_t stride = 0;
    std::span<const Vec3> points;
    std::span<const char> sees;  // whether a pixel sees the ground
};

// Adds `full` times the share of the sun that reaches each pixel's point, [height, width]. The share is looked up at
// the corners and in the middle of blocks of 4 x 4 pixels. Blocks whose middle is not what the corners say, those with
// an edge and their neighbours are looked up whole; in all others the share is interpolated.
void addSun(const PixelPoints& points, const SunMaps& maps, Vec3 full, int threads, std::span<Vec3> light);

}  // namespace penumbra
