#include "fit/papers/capture/merge_unbounded.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

MergedCode mergeCodes(std::span<const std::uint8_t> codes, std::span<const double> exposures,
                      const CameraResponse& response, int channel) {
    assert(!codes.empty() && codes.size() == exposures.size());
    const std::array<float, 256>& curve = response.exposure[std::size_t(channel)];
    double numerator = 0, denominator = 0;
    for (std::size_t k = 0; k < codes.size(); ++k) {
        const int z = codes[k];
        if (z >= kMaxCode || z <= kMinCode) continue;
        const double weight = std::min(z, 255 - z), t = exposures[k];
        numerator += weight * t * double(curve[codes[k]]);
        denominator += weight * t * t;
    }
    if (denominator > 0) return {numerator / denominator, false};
    const auto shortest = std::size_t(std::ranges::min_element(exposures) - exposures.begin());
    const auto longest = std::size_t(std::ranges::max_element(exposures) - exposures.begin());
    const bool clipped = codes[shortest] >= kMaxCode;
    const std::size_t told = clipped ? shortest : longest;
    return {double(curve[codes[told]]) / exposures[told], clipped};
}

RadiancePicture mergeUnbounded(std::span<const TexturePicture> pictures, std::span<const double> exposures,
                               const CameraResponse& response) {
    assert(!pictures.empty());
    RadiancePicture out;
    out.width = pictures[0].width;
    out.height = pictures[0].height;
    out.radiance.resize(std::size_t(out.width) * std::size_t(out.height));
    out.at_least.resize(out.radiance.size());
    out.at_most.resize(out.radiance.size());
    std::vector<std::uint8_t> codes(pictures.size());
    for (std::size_t pixel = 0; pixel < out.radiance.size(); ++pixel)
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t k = 0; k < pictures.size(); ++k) codes[k] = pictures[k].rgb[3 * pixel + c];
            const MergedCode merged = mergeCodes(codes, exposures, response, int(c));
            out.radiance[pixel][int(c)] = float(merged.radiance);
            if (merged.clipped) out.at_least[pixel] |= std::uint8_t(1u << c);
        }
    return out;
}

}  // namespace penumbra
