#pragma once
// The grain of a photograph: how much the codes of neighbouring pixels differ where the picture is smooth.
#include <array>
#include <cstdint>
#include <vector>

#include "formats/image/texture_file.h"

namespace penumbra {

// deviation[channel][level]: standard deviation of codes around level * 32 + 16, in codes.
struct PlateGrain {
    std::array<std::array<float, 8>, 3> deviation{};
};

// Measures it from the second differences of 3 x 3 pixels along both axes, which a plane and an edge along either axis
// leave at 0 (Immerkaer, Fast noise variance estimation, 1996). The median of their sizes keeps textures out. A level
// that fewer than 200 pixels have takes that of its neighbours.
PlateGrain measureGrain(const TexturePicture& plate);

// Returns normal deviates of these deviations for every code, [height, width, 3]. The same number and picture give the
// same grain.
std::vector<float> grainFor(const PlateGrain& grain, const TexturePicture& codes, std::uint64_t number);

}  // namespace penumbra
