#include "player/render/image_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "player/render/flip.h"

namespace penumbra {

namespace {

constexpr double kGrey = 60.0 / 255;  // sRGB colour behind both pictures, as in scripts/figures/flip.py
constexpr int kFlipReach = 10;        // pixels that FLIP's filters see, at least

// A picture as RGBA with 8 bits.
struct Displayed {
    int width, height;
    std::vector<std::uint8_t> bytes;

    const std::uint8_t* at(std::size_t pixel) const { return bytes.data() + 4 * pixel; }
};

// Pixels [left, right) x [top, bottom).
struct Box {
    int left, top, right, bottom;
};

// Returns what either picture covers, and as much around it as FLIP sees. Beyond that there is only grey.
Box coveredBox(const Displayed& a, const Displayed& b) {
    Box box{a.width, a.height, 0, 0};
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(a.width) + std::size_t(x);
            if (a.at(i)[3] == 0 && b.at(i)[3] == 0) continue;
            box = {std::min(box.left, x), std::min(box.top, y), std::max(box.right, x + 1),
                   std::max(box.bottom, y + 1)};
        }
    return {std::max(box.left - kFlipReach, 0), std::max(box.top - kFlipReach, 0),
            std::min(box.right + kFlipReach, a.width), std::min(box.bottom + kFlipReach, a.height)};
}

// Puts a picture over the grey in sRGB, and returns linear colours.
std::vector<Vec3> overGrey(const Displayed& picture, const Box& box) {
    std::vector<Vec3> out;
    for (int y = box.top; y < box.bottom; ++y)
        for (int x = box.left; x < box.right; ++x) {
            const std::uint8_t* p = picture.at(std::size_t(y) * std::size_t(picture.width) + std::size_t(x));
            const double alpha = p[3] / 255.0;
            Vec3 color;
            for (int c = 0; c < 3; ++c) {
                const double srgb = p[c] / 255.0 * alpha + kGrey * (1 - alpha);
                color[c] = linearFromSrgb(float(srgb));
            }
            out.push_back(color);
        }
    return out;
}

void addFlip(const Displayed& model, const Displayed& truth, int threads, ImageError& error) {
    const Box box = coveredBox(model, truth);
    const int width = box.right - box.left, height = box.bottom - box.top;
    if (width <= 0 || height <= 0) return;
    const std::vector<float> map = flipMap(width, height, overGrey(truth, box), overGrey(model, box), threads);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = std::size_t(box.top + y) * std::size_t(model.width) + std::size_t(box.left + x);
            if (model.at(i)[3] == 0 && truth.at(i)[3] == 0) continue;
            error.flip_sum += double(map[std::size_t(y) * std::size_t(width) + std::size_t(x)]);
            ++error.flip_pixels;
        }
}

}  // namespace

void ImageError::add(const ImageError& other) {
    pixels += other.pixels;
    squares += other.squares;
    flip_sum += other.flip_sum;
    flip_pixels += other.flip_pixels;
}

double ImageError::rmse() const { return std::sqrt(squares / (3 * double(pixels))); }

double ImageError::flip() const { return flip_sum / double(flip_pixels); }

ImageError imageError(const Image& model, const Image& truth, float exposure, ImageMetrics metrics, int threads) {
    assert(model.alpha.size() == truth.alpha.size() && !model.alpha.empty());
    const Displayed a{model.width, model.height, displayedBytes(model, exposure)};
    const Displayed b{truth.width, truth.height, displayedBytes(truth, exposure)};
    ImageError error;
    for (std::size_t i = 0; i < model.pixels.size(); ++i) {
        if (a.at(i)[3] < 255 || b.at(i)[3] < 255) continue;
        ++error.pixels;
        for (int c = 0; c < 3; ++c) {
            const double difference = double(a.at(i)[c]) - b.at(i)[c];
            error.squares += difference * difference;
        }
    }
    if (metrics == ImageMetrics::kRmseAndFlip) addFlip(a, b, threads, error);
    // A PNG shows NaN as black, which the other picture may show there, too.
    const auto isNan = [](Vec3 p) { return std::isnan(p.x + p.y + p.z); };
    if (std::ranges::any_of(model.pixels, isNan) || std::ranges::any_of(truth.pixels, isNan))
        error.squares = error.flip_sum = std::numeric_limits<double>::quiet_NaN();
    return error;
}

}  // namespace penumbra
