#pragma once
// Merges photographs of one view, taken with several exposures, into a picture of radiance.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/image/texture_file.h"
#include "sh/camera_response.h"

namespace penumbra {

// Codes from kClippedCode on are clipped, and codes up to kDarkCode are noise. JPEG blurs colors: where one channel is
// clipped, the others beside it fall a little below 255, which is why this is less than kMaxCode.
constexpr int kClippedCode = 248, kDarkCode = 4;

// A picture of radiance, in the units in which exposure 1 shows radiance 1 as the full scale of the response.
struct RadiancePicture {
    int width = 0, height = 0;
    std::vector<Vec3> radiance;          // [height, width]
    std::vector<std::uint8_t> at_least;  // [height, width], bit c: channel c was clipped in every exposure
    std::vector<std::uint8_t> at_most;   // [height, width], bit c: channel c was too dark in every exposure
};

// Weights every code z by min(z, 255 - z) and its exposure: L = sum w t x / sum w t^2, x = response(z). A clipped code
// says L >= response(kClippedCode) / t, and no merged radiance is below that. Where no code can be used, the shortest
// exposure tells if any was clipped, and else the longest. `pictures` have one size; `exposures` [pictures] are above
// 0. Colors of JPEG files are blurred, so a channel of the sun may be dark in the shortest exposure alone: without the
// lower bounds that channel would be lost.
RadiancePicture mergeExposures(std::span<const TexturePicture> pictures, std::span<const double> exposures,
                               const CameraResponse& response);

}  // namespace penumbra
