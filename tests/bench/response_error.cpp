// The response that penumbra-fit response found against the true light of its bracket.
//
//   response_error BRACKET.json TRUE.exr cam.response.json
//
// Flat places of the true picture (5 x 5 pixels within 8%) are put into bins of light times exposure, and the median of
// their codes says which code that light has. Prints the rms of response(code) / light - 1 of each channel over the
// bins with codes 10 to 245, after the best factor, which no bracket tells.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

#include "fit/camera/bracket_pictures.h"
#include "formats/camera/camera_file.h"
#include "formats/image/image_file.h"

namespace penumbra {
namespace {

struct Bin {
    std::vector<double> codes;
    double log_light = 0;
};

// Mean and deviation of 25 values around a pixel.
template <class At>
std::pair<double, double> around(int x, int y, const At& at) {
    double sum = 0, squares = 0;
    for (int j = y - 2; j <= y + 2; ++j)
        for (int i = x - 2; i <= x + 2; ++i) sum += at(i, j), squares += at(i, j) * at(i, j);
    return {sum / 25, std::sqrt(std::max(squares / 25 - sum * sum / 625, 0.0))};
}

std::map<int, Bin> binsOf(const BracketPictures& bracket, const Image& truth, int channel) {
    std::map<int, Bin> bins;
    for (int y = 2; y < truth.height - 2; ++y)
        for (int x = 2; x < truth.width - 2; ++x) {
            const auto [light, spread] = around(x, y, [&](int i, int j) {
                return double(truth.pixels[std::size_t(j) * std::size_t(truth.width) + std::size_t(i)][channel]);
            });
            if (!(spread < 0.08 * light)) continue;
            for (std::size_t k = 0; k < bracket.pictures.size(); ++k) {
                const double shown = std::log(light * bracket.exposures[k]);
                if (shown < -7.5 || shown > 0.1) continue;
                const auto [code, deviation] = around(x, y, [&](int i, int j) {
                    const std::size_t at = std::size_t(j) * std::size_t(truth.width) + std::size_t(i);
                    return double(bracket.pictures[k].rgb[3 * at + std::size_t(channel)]);
                });
                if (deviation > 12) continue;
                Bin& bin = bins[int(std::floor(shown / 0.05))];
                bin.codes.push_back(code);
                bin.log_light += shown;
            }
        }
    return bins;
}

double errorOf(const CameraResponse& response, std::map<int, Bin> bins, int channel) {
    std::vector<double> ratios;
    for (auto& [number, bin] : bins) {
        if (bin.codes.size() < 20) continue;
        std::ranges::nth_element(bin.codes, bin.codes.begin() + std::ptrdiff_t(bin.codes.size() / 2));
        const double code = bin.codes[bin.codes.size() / 2];
        if (code < 10 || code > 245) continue;
        const double light = std::exp(bin.log_light / double(bin.codes.size()));
        ratios.push_back(double(exposureOf(response, channel, float(code))) / light);
    }
    double sum = 0, squares = 0, rms = 0;
    for (const double ratio : ratios) sum += ratio, squares += ratio * ratio;
    for (const double ratio : ratios) rms += std::pow(ratio * sum / squares - 1, 2) / double(ratios.size());
    return ratios.empty() ? 1 : std::sqrt(rms);
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) try {
    using namespace penumbra;
    if (argc != 4) {
        std::fprintf(stderr, "usage: response_error BRACKET.json TRUE.exr cam.response.json\n");
        return 1;
    }
    const BracketPictures bracket = readPictures(readBracket(argv[1]));
    const Image truth = readImage(argv[2]);
    const CameraResponse response = readResponse(argv[3]);
    if (truth.width != bracket.pictures[0].width || truth.height != bracket.pictures[0].height) {
        std::fprintf(stderr, "%s: its size is not that of the bracket\n", argv[2]);
        return 3;
    }
    for (int channel = 0; channel < 3; ++channel)
        std::printf("%.5f\n", errorOf(response, binsOf(bracket, truth, channel), channel));
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "response_error: %s\n", error.what());
    return 3;
}
