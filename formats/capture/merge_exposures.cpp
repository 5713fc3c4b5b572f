#include "formats/capture/merge_exposures.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace penumbra {

namespace {

// Tables for the codes of one picture, so that a pixel costs one look-up.
struct CodeTable {
    std::array<std::array<float, 256>, 3> numerator{}, radiance{};  // w t x, and x / t
    std::array<float, 256> denominator{};                           // w t^2
    std::array<float, 3> bound{};                                   // bound for clipped codes
};

CodeTable tableOf(double exposure, double longest, const CameraResponse& response) {
    CodeTable table;
    const double t = exposure / longest;  // keeps squares of small exposures away from the smallest floats
    for (int z = 0; z < 256; ++z) {
        const double weight = z >= kClippedCode || z <= kDarkCode ? 0 : std::min(z, 255 - z);
        const auto code = std::size_t(z);
        table.denominator[code] = float(weight * t * t * longest);
        for (std::size_t c = 0; c < 3; ++c) {
            table.numerator[c][code] = float(weight * t * double(response.exposure[c][code]));
            table.radiance[c][code] = float(double(response.exposure[c][code]) / exposure);
        }
    }
    for (std::size_t c = 0; c < 3; ++c) table.bound[c] = table.radiance[c][kClippedCode];
    return table;
}

struct Merger {
    std::span<const TexturePicture> pictures;
    std::vector<CodeTable> tables;
    std::size_t shortest = 0, longest = 0;

    void merge(std::size_t pixel, int channel, RadiancePicture& out) const {
        const std::size_t at = 3 * pixel + std::size_t(channel);
        const auto c = std::size_t(channel);
        float numerator = 0, denominator = 0, bound = 0;
        for (std::size_t k = 0; k < pictures.size(); ++k) {
            const std::uint8_t code = pictures[k].rgb[at];
            numerator += tables[k].numerator[c][code];
            denominator += tables[k].denominator[code];
            if (code >= kClippedCode) bound = std::max(bound, tables[k].bound[c]);
        }
        const std::uint8_t bit = std::uint8_t(1u << c);
        float value = 0;
        if (denominator > 0) {
            value = numerator / denominator;
        } else if (bound > 0) {
            const std::uint8_t code = pictures[shortest].rgb[at];
            value = tables[shortest].radiance[c][code];
            out.at_least[pixel] |= code >= kClippedCode ? bit : 0;
        } else {
            value = tables[longest].radiance[c][pictures[longest].rgb[at]];
            out.at_most[pixel] |= bit;
        }
        out.radiance[pixel][channel] = std::max(value, bound);
    }
};

}  // namespace

RadiancePicture mergeExposures(std::span<const TexturePicture> pictures, std::span<const double> exposures,
                               const CameraResponse& response) {
    assert(!pictures.empty() && pictures.size() == exposures.size());
    RadiancePicture out;
    out.width = pictures[0].width;
    out.height = pictures[0].height;
    const std::size_t pixels = std::size_t(out.width) * std::size_t(out.height);
    out.radiance.resize(pixels);
    out.at_least.resize(pixels);
    out.at_most.resize(pixels);
    Merger merger{pictures, {}};
    merger.shortest = std::size_t(std::ranges::min_element(exposures) - exposures.begin());
    merger.longest = std::size_t(std::ranges::max_element(exposures) - exposures.begin());
    for (double exposure : exposures) merger.tables.push_back(tableOf(exposure, exposures[merger.longest], response));
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
        for (int channel = 0; channel < 3; ++channel) merger.merge(pixel, channel, out);
    return out;
}

}  // namespace penumbra
