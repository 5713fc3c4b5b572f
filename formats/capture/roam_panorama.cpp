#include "formats/capture/roam_panorama.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

constexpr float kClippedWeight = 1e-3f;  // weight of a picture where it is clipped

// Falls from 1 in the middle of a picture to 0 at its border, so that seams do not show.
float weightAt(const PinholeCamera& camera, PixelPoint pixel) {
    const double x = 1 - std::abs(2 * (pixel.x + 0.5) / camera.width - 1);
    const double y = 1 - std::abs(2 * (pixel.y + 0.5) / camera.height - 1);
    return float(std::max(1e-6, x * y));
}

SeenLight lightOf(const PosedPicture& shot, Vec3d direction, const std::optional<Vec3d>& ground) {
    const std::optional<PixelPoint> pixel = ground ? pixelOfPlace(shot, *ground) : pixelOfRay(shot, direction);
    if (!pixel) return {};
    SeenLight seen = lightAt(shot.picture, *pixel);
    const bool clipped = seen.uncertain.x > 0 || seen.uncertain.y > 0 || seen.uncertain.z > 0;
    seen.weight = weightAt(shot.camera, *pixel) * (clipped ? kClippedWeight : 1);
    return seen;
}

}  // namespace

Panorama panoramaOfPictures(std::span<const PosedPicture> shots, const RoamPanoramaOptions& options) {
    return paintPanorama(options.width, options.samples, options.threads, [&](Vec3d direction) -> SeenLight {
        const std::optional<Vec3d> ground = groundBelow(options.ground, options.at, direction);
        SeenLight sum;
        for (const PosedPicture& shot : shots) {
            const SeenLight seen = lightOf(shot, direction, ground);
            if (!(seen.weight > 0)) continue;
            sum.radiance += seen.weight * seen.radiance;
            sum.uncertain += seen.weight * seen.uncertain;
            sum.dark += seen.weight * seen.dark;
            sum.weight += seen.weight;
        }
        if (!(sum.weight > 0)) return {};
        const float scale = 1 / sum.weight;
        return {scale * sum.radiance, scale * sum.uncertain, scale * sum.dark, 1};
    });
}

}  // namespace penumbra
