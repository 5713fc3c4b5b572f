#include "player/composite/lens_resampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr double kSharper = 1.5;  // pixels of the plain picture for one of the camera, where the lens leaves it alone

struct Premultiplied {
    Vec3 color;
    float alpha = 0;
};

// Bilinear between the centers of pixels; outside of the picture nothing is drawn.
Premultiplied at(const Image& image, float x, float y) {
    Premultiplied sum;
    const float left = std::floor(x), top = std::floor(y);
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const int px = int(left) + dx, py = int(top) + dy;
            if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
            const float weight = (dx ? x - left : 1 - (x - left)) * (dy ? y - top : 1 - (y - top));
            const std::size_t i = std::size_t(py) * std::size_t(image.width) + std::size_t(px);
            sum.color += image.pixels[i] * weight;
            sum.alpha += image.alpha[i] * weight;
        }
    return sum;
}

// The plain camera that sees what all pixels at the border of the other see.
PinholeCamera plainOf(const PinholeCamera& camera) {
    double low_x = 0, low_y = 0, high_x = 0, high_y = 0;
    const auto include = [&](double x, double y) {
        const Vec3d ray = viewRay(camera, {x, y});
        low_x = std::min(low_x, ray.x / ray.z);
        high_x = std::max(high_x, ray.x / ray.z);
        low_y = std::min(low_y, ray.y / ray.z);
        high_y = std::max(high_y, ray.y / ray.z);
    };
    for (int x = 0; x < camera.width; ++x)
        for (const int y : {0, camera.height - 1}) include(x, y);
    for (int y = 0; y < camera.height; ++y)
        for (const int x : {0, camera.width - 1}) include(x, y);
    PinholeCamera out;
    out.f = camera.f * kSharper;
    constexpr double kBorder = 2;  // pixels
    out.cx = std::ceil(-low_x * out.f) + kBorder;
    out.cy = std::ceil(-low_y * out.f) + kBorder;
    out.width = int(out.cx + std::ceil(high_x * out.f) + kBorder) + 1;
    out.height = int(out.cy + std::ceil(high_y * out.f) + kBorder) + 1;
    return out;
}

}  // namespace

LensResampler::LensResampler(const PinholeCamera& camera) : camera_(camera), plain_(camera) {
    if (camera.k1 == 0 && camera.k2 == 0) return;
    plain_ = plainOf(camera);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            for (int part = 0; part < 4; ++part) {
                const double dx = part % 2 ? 0.25 : -0.25, dy = part / 2 ? 0.25 : -0.25;
                const Vec3d ray = viewRay(camera, {x + dx, y + dy});
                places_.push_back(float(plain_.cx + plain_.f * ray.x / ray.z));
                places_.push_back(float(plain_.cy + plain_.f * ray.y / ray.z));
            }
}

void LensResampler::resample(const DrawnPart& drawn, int threads, Image& out) const {
    const auto width = std::size_t(camera_.width);
    out.width = camera_.width;
    out.height = camera_.height;
    out.pixels.assign(width * std::size_t(camera_.height), Vec3{});
    out.alpha.assign(out.pixels.size(), 0.0f);
    const Image& image = drawn.image;
    if (image.pixels.empty()) return;
    if (places_.empty()) {
        for (int y = 0; y < std::min(image.height, camera_.height - drawn.y); ++y) {
            const std::size_t to = std::size_t(y + drawn.y) * width + std::size_t(drawn.x),
                              from = std::size_t(y) * std::size_t(image.width);
            const auto count = std::ptrdiff_t(std::min(image.width, camera_.width - drawn.x));
            std::copy_n(image.pixels.begin() + std::ptrdiff_t(from), count, out.pixels.begin() + std::ptrdiff_t(to));
            std::copy_n(image.alpha.begin() + std::ptrdiff_t(from), count, out.alpha.begin() + std::ptrdiff_t(to));
        }
        return;
    }
    parallelFor(std::size_t(camera_.height), threads, [&](std::size_t y) {
        for (std::size_t x = 0; x < width; ++x) {
            const float* place = &places_[8 * (y * width + x)];
            constexpr float kFar = 4;  // pixels: the places of a pixel are nearer to one another
            const float px = place[0] - float(drawn.x), py = place[1] - float(drawn.y);
            if (px < -kFar || py < -kFar || px > float(image.width) + kFar || py > float(image.height) + kFar) continue;
            Premultiplied sum;
            for (int part = 0; part < 4; ++part, place += 2) {
                const Premultiplied one = at(image, place[0] - float(drawn.x), place[1] - float(drawn.y));
                sum.color += one.color * 0.25f;
                sum.alpha += one.alpha * 0.25f;
            }
            out.pixels[y * width + x] = sum.color;
            out.alpha[y * width + x] = sum.alpha;
        }
    });
}

}  // namespace penumbra
