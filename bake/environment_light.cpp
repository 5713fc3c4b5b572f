#include "bake/environment_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "formats/light_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

constexpr double kPi = std::numbers::pi;

static double luminance(Vec3d rgb) { return std::abs(0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z); }

// Solid angle of one pixel of row y, steradians.
static double solidAngle(int y, int width, int height) {
    return 2 * kPi / width * (std::cos(kPi * y / height) - std::cos(kPi * (y + 1) / height));
}

static std::size_t pixelOf(Vec3d direction, int width, int height) {
    double u, v;
    latLongCoordinates(direction, u, v);
    const int x = std::clamp(int(u * width), 0, width - 1), y = std::clamp(int(v * height), 0, height - 1);
    return std::size_t(y) * std::size_t(width) + std::size_t(x);
}

void EnvironmentLight::makeTable(const std::vector<double>& power) {
    assert(power.size() == std::size_t(width_) * std::size_t(height_));
    cumulative_.assign(power.size() + 1, 0);
    for (std::size_t i = 0; i < power.size(); ++i)
        cumulative_[i + 1] = cumulative_[i] + power[i] * solidAngle(int(i) / width_, width_, height_);
    const double total = cumulative_.back();
    if (total > 0) {
        for (double& c : cumulative_) c /= total;
        return;
    }
    // A black light: any density will do.
    for (std::size_t i = 0; i < cumulative_.size(); ++i) cumulative_[i] = double(i) / double(power.size());
}

EnvironmentLight EnvironmentLight::white() { return fromImage({1, 1, {{1, 1, 1}}, {}}); }

EnvironmentLight EnvironmentLight::fromImage(Image image) {
    EnvironmentLight light;
    light.width_ = image.width;
    light.height_ = image.height;
    light.image_ = std::move(image);
    std::vector<double> power;
    for (Vec3 pixel : light.image_.pixels) power.push_back(luminance(toDouble(pixel)));
    light.makeTable(power);
    return light;
}

EnvironmentLight EnvironmentLight::fromSh(int order, std::vector<double> sh) {
    assert(sh.size() == 3 * std::size_t(coefficientCount(order)));
    EnvironmentLight light;
    light.order_ = order;
    light.sh_ = std::move(sh);
    light.width_ = 128;
    light.height_ = 64;
    std::vector<double> power;
    for (int y = 0; y < light.height_; ++y)
        for (int x = 0; x < light.width_; ++x)
            power.push_back(
                luminance(light.radiance(latLongDirection((x + 0.5) / light.width_, (y + 0.5) / light.height_))));
    light.makeTable(power);
    return light;
}

EnvironmentLight EnvironmentLight::bandLimited(int order) const {
    if (image_.pixels.empty()) {
        const int kept = std::min(order, order_);
        return fromSh(kept, {sh_.begin(), sh_.begin() + 3 * coefficientCount(kept)});
    }
    // The basis is constant over a cell: cells of at most 1/256 turn keep that error below 1e-4.
    const int split = std::max(1, 256 / width_), rows = height_ * std::max(split, 128 / height_),
              columns = width_ * split;
    std::vector<double> sh(3 * std::size_t(coefficientCount(order)), 0), basis(sh.size() / 3);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const Vec3d direction = latLongDirection((x + 0.5) / columns, (y + 0.5) / rows);
            const Vec3d flux = radiance(direction) * solidAngle(y, columns, rows);
            evalBasis(order, direction, basis);
            for (std::size_t i = 0; i < basis.size(); ++i)
                for (int c = 0; c < 3; ++c) sh[3 * i + std::size_t(c)] += flux[c] * basis[i];
        }
    return fromSh(order, std::move(sh));
}

Vec3d EnvironmentLight::radiance(Vec3d direction) const {
    if (!image_.pixels.empty()) return toDouble(image_.pixels[pixelOf(direction, width_, height_)]);
    double basis[coefficientCount(kMaxOrder)];
    const auto count = std::size_t(coefficientCount(order_));
    evalBasis(order_, direction, std::span(basis, count));
    Vec3d sum;
    for (std::size_t i = 0; i < count; ++i) sum += Vec3d{sh_[3 * i], sh_[3 * i + 1], sh_[3 * i + 2]} * basis[i];
    return sum;
}

LightSample EnvironmentLight::sample(double u, double v) const {
    const auto above = std::upper_bound(cumulative_.begin() + 1, cumulative_.end() - 1, u);
    const auto pixel = std::size_t(above - cumulative_.begin()) - 1;
    const double chance = cumulative_[pixel + 1] - cumulative_[pixel];
    const int y = int(pixel) / width_, x = int(pixel) % width_;
    // What is left of u is uniform within the pixel; its height is uniform in the cosine.
    const double across = chance > 0 ? std::clamp((u - cumulative_[pixel]) / chance, 0.0, 1.0) : 0.5;
    const double top = std::cos(kPi * y / height_), bottom = std::cos(kPi * (y + 1) / height_);
    const double polar = std::acos(std::clamp(top + (bottom - top) * v, -1.0, 1.0)) / kPi;
    return {latLongDirection((x + across) / width_, polar), chance / solidAngle(y, width_, height_)};
}

double EnvironmentLight::density(Vec3d direction) const {
    const std::size_t pixel = pixelOf(direction, width_, height_);
    return (cumulative_[pixel + 1] - cumulative_[pixel]) / solidAngle(int(pixel) / width_, width_, height_);
}

EnvironmentLight readEnvironmentLight(const std::filesystem::path& path) {
    if (path.extension() != ".h5") return EnvironmentLight::fromImage(readImage(path));
    const LightFile file = readLight(path);
    return EnvironmentLight::fromSh(file.order, file.sh);
}

}  // namespace penumbra
