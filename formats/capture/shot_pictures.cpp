#include "formats/capture/shot_pictures.h"

#include <algorithm>
#include <numeric>

#include "formats/capture/merge_exposures.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "sh/key_values.h"

namespace penumbra {

namespace {

constexpr double kAlike = 1e-6;  // relative difference of exposures that are the same
constexpr double kDarker = 1;    // codes by which a longer exposure may be darker on the mean, for noise

double meanCode(const TexturePicture& picture) {
    return std::accumulate(picture.rgb.begin(), picture.rgb.end(), 0.0) / double(picture.rgb.size());
}

std::string sizeText(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

std::string described(const ExposureSet& set, std::size_t i) {
    return set.files[i].string() + " (exposure " + shortest(set.exposures[i]) + ")";
}

bool allCodes(const TexturePicture& picture, bool (*match)(std::uint8_t)) {
    return std::ranges::all_of(picture.rgb, match);
}

bool isClipped(std::uint8_t code) { return code >= kClippedCode; }
bool isDark(std::uint8_t code) { return code <= kDarkCode; }

// The pictures, shortest exposure first.
std::vector<std::size_t> byExposure(const ExposureSet& set) {
    std::vector<std::size_t> order(set.exposures.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return set.exposures[a] < set.exposures[b]; });
    return order;
}

// Pictures that are black or white all over may well be the same.
bool tellsAnything(const TexturePicture& picture) {
    return !allCodes(picture, [](std::uint8_t z) { return z <= kDarkCode || z >= kClippedCode; });
}

}  // namespace

std::vector<TexturePicture> readShotPictures(std::span<const std::filesystem::path> files, const PinholeCamera& camera,
                                             int threads) {
    std::vector<TexturePicture> pictures(files.size());
    parallelFor(files.size(), threads, [&](std::size_t i) {
        TexturePicture picture = readTexture(files[i], files[i].string());
        if (picture.width != camera.width || picture.height != camera.height)
            throw InvalidInput(files[i].string() + ": has " + sizeText(picture.width, picture.height) +
                               " pixels, and the camera has " + sizeText(camera.width, camera.height));
        pictures[i] = std::move(picture);
    });
    return pictures;
}

std::string findExposureProblem(const ExposureSet& set) {
    const std::vector<std::size_t> order = byExposure(set);
    for (std::size_t i = 0; i + 1 < order.size(); ++i) {
        const std::size_t shorter = order[i], longer = order[i + 1];
        if (set.exposures[longer] <= set.exposures[shorter] * (1 + kAlike))
            return described(set, shorter) + " and " + set.files[longer].string() + " have the same exposure";
        const double dark = meanCode(set.pictures[shorter]), light = meanCode(set.pictures[longer]);
        if (light < dark - kDarker)
            return described(set, longer) + " is darker than " + described(set, shorter) +
                   ": exposures are out of order";
        if (set.pictures[shorter].rgb == set.pictures[longer].rgb && tellsAnything(set.pictures[longer]))
            return described(set, longer) + " is the same picture as " + described(set, shorter);
    }
    return "";
}

std::string findProblem(const ExposureSet& set) {
    if (const std::string problem = findExposureProblem(set); !problem.empty()) return problem;
    const std::vector<std::size_t> order = byExposure(set);
    if (allCodes(set.pictures[order.front()], isClipped))
        return described(set, order.front()) + " is clipped everywhere, and so are all longer exposures";
    if (allCodes(set.pictures[order.back()], isDark))
        return described(set, order.back()) + " is black everywhere, and so are all shorter exposures";
    return "";
}

std::string findDarkness(std::span<const TexturePicture> pictures) {
    if (std::ranges::all_of(pictures, [](const TexturePicture& one) { return allCodes(one, isClipped); }))
        return "every picture is clipped everywhere: take shorter exposures";
    if (std::ranges::all_of(pictures, [](const TexturePicture& one) { return allCodes(one, isDark); }))
        return "every picture is black everywhere: take longer exposures";
    return "";
}

}  // namespace penumbra
