#pragma once
// The merge of exposures without lower bounds, as it stands in the literature (Debevec and Malik 1997): a reference to
// compare mergeExposures() with. JPEG files blur colors, and a channel of the sun that is dark in the shortest exposure
// alone is lost.
#include <span>

#include "formats/capture/merge_exposures.h"

namespace penumbra {

struct MergedCode {
    double radiance = 0;
    bool clipped = false;
};
// Merges the codes of one pixel and channel. w = min(z, 255 - z), and 0 for z >= 250 or z <= 3; L = sum w t x / sum w
// t^2. Without a weight the shortest exposure tells if it is clipped, and else the longest.
MergedCode mergeCodes(std::span<const std::uint8_t> codes, std::span<const double> exposures,
                      const CameraResponse& response, int channel);
RadiancePicture mergeUnbounded(std::span<const TexturePicture> pictures, std::span<const double> exposures,
                               const CameraResponse& response);

}  // namespace penumbra
