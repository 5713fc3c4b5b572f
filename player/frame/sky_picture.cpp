#include "player/frame/sky_picture.h"

#include <algorithm>

#include "formats/common/fp16.h"
#include "formats/image/image_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr int kShWidth = 128;  // width of a picture of SH: 13 texels for each half wave of 5 bands

Vec3 radianceOf(const LightView& light, Vec3 direction, std::vector<float>& basis) {
    evalBasis(light.order, direction, basis);
    Vec3 sum;
    for (std::size_t i = 0; i < basis.size(); ++i)
        sum += Vec3{light.sh[3 * i], light.sh[3 * i + 1], light.sh[3 * i + 2]} * basis[i];
    return {std::max(sum.x, 0.0f), std::max(sum.y, 0.0f), std::max(sum.z, 0.0f)};
}

SkyPicture pictureOfSh(const LightView& light) {
    SkyPicture sky{kShWidth, kShWidth / 2, {}, {}};
    std::vector<float> basis(std::size_t(coefficientCount(light.order)));
    for (int row = 0; row < sky.height; ++row)
        for (int column = 0; column < sky.width; ++column) {
            const Vec3d direction = latLongDirection((column + 0.5) / sky.width, (row + 0.5) / sky.height);
            const Vec3 rgb = radianceOf(light, toFloat(direction), basis);
            sky.texels.push_back({floatToHalf(rgb.x), floatToHalf(rgb.y), floatToHalf(rgb.z), 0});
        }
    return sky;
}

}  // namespace

namespace {

constexpr int kMaxSkyWidth = 2048;

// The mean of the picture in a texel of the sky.
Vec3 texelOf(const EnvironmentMap& map, const SkyPicture& sky, int row, int column, int samples) {
    Vec3 sum;
    for (int i = 0; i < samples * samples; ++i) {
        const double u = (column + (i % samples + 0.5) / samples) / sky.width,
                     v = (row + (i / samples + 0.5) / samples) / sky.height;
        const int x = int(u * map.image.width), y = int(v * map.image.height);
        const MapPixel at =
            map.layout == MapLayout::kLatLong ? MapPixel{x, y} : mapPixel(map.shape(), latLongDirection(u, v));
        sum += map.image.pixels[std::size_t(at.y) * std::size_t(map.image.width) + std::size_t(at.x)];
    }
    return sum / float(samples * samples);
}

std::uint16_t texelHalf(float radiance) { return floatToHalf(std::clamp(radiance, 0.0f, 65504.0f)); }

}  // namespace

SkyPicture skyPicture(const EnvironmentMap& map) {
    const int width = std::min(kMaxSkyWidth, std::max(map.image.width, map.image.height)) & ~1;
    SkyPicture sky{width, width / 2, {}, {}};
    const int samples = std::max(1, map.image.width / width);
    sky.texels.reserve(std::size_t(sky.width) * std::size_t(sky.height));
    for (int row = 0; row < sky.height; ++row)
        for (int column = 0; column < sky.width; ++column) {
            const Vec3 rgb = texelOf(map, sky, row, column, samples);
            sky.texels.push_back({texelHalf(rgb.x), texelHalf(rgb.y), texelHalf(rgb.z), 0});
        }
    return sky;
}

SkyPicture skyPicture(const LightView& light) {
    if (light.picture.width == 0) return pictureOfSh(light);
    SkyPicture sky{light.picture.width, light.picture.height, {}, {light.suns.begin(), light.suns.end()}};
    for (std::size_t i = 0; i < light.picture.texels.size(); i += 3)
        sky.texels.push_back({light.picture.texels[i], light.picture.texels[i + 1], light.picture.texels[i + 2], 0});
    return sky;
}

}  // namespace penumbra
