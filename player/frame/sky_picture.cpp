#include "player/frame/sky_picture.h"

#include <algorithm>

#include "formats/common/fp16.h"
#include "formats/image/image_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr int kShWidth = 128;  // of a picture of SH: 13 texels for each half wave of 5 bands

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

SkyPicture skyPicture(const LightView& light) {
    if (light.picture.width == 0) return pictureOfSh(light);
    SkyPicture sky{light.picture.width, light.picture.height, {}, {light.suns.begin(), light.suns.end()}};
    for (std::size_t i = 0; i < light.picture.texels.size(); i += 3)
        sky.texels.push_back({light.picture.texels[i], light.picture.texels[i + 1], light.picture.texels[i + 2], 0});
    return sky;
}

}  // namespace penumbra
