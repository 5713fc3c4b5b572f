#include "formats/capture/posed_picture.h"

#include <algorithm>
#include <cmath>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

std::optional<PixelPoint> pixelInside(const PinholeCamera& camera, Vec3d point) {
    const std::optional<PixelPoint> pixel = project(camera, point);
    if (!pixel) return std::nullopt;
    const bool inside =
        pixel->x > -0.5 && pixel->y > -0.5 && pixel->x < camera.width - 0.5 && pixel->y < camera.height - 0.5;
    if (!inside) return std::nullopt;
    return pixel;
}

Vec3 maskedBy(Vec3 radiance, std::uint8_t channels) {
    return {channels & 1 ? radiance.x : 0, channels & 2 ? radiance.y : 0, channels & 4 ? radiance.z : 0};
}

// Sums of what samples saw.
struct LightSum {
    Vec3d radiance, uncertain;
    double dark = 0, weight = 0;
    void add(const SeenLight& seen) {
        radiance += double(seen.weight) * toDouble(seen.radiance);
        uncertain += double(seen.weight) * toDouble(seen.uncertain);
        dark += double(seen.weight) * double(seen.dark);
        weight += double(seen.weight);
    }
};

}  // namespace

std::optional<PixelPoint> pixelOfPlace(const PosedPicture& shot, Vec3d place) {
    return pixelInside(shot.camera, shot.pose.rotation * place + shot.pose.translation);
}

std::optional<PixelPoint> pixelOfRay(const PosedPicture& shot, Vec3d ray) {
    return pixelInside(shot.camera, shot.pose.rotation * ray);
}

SeenLight lightAt(const RadiancePicture& picture, PixelPoint pixel) {
    const double x = std::clamp(pixel.x, 0.0, picture.width - 1.0), y = std::clamp(pixel.y, 0.0, picture.height - 1.0);
    const std::size_t left = std::size_t(x), top = std::size_t(y), width = std::size_t(picture.width);
    const std::size_t right = std::min(left + 1, width - 1),
                      bottom = std::min(top + 1, std::size_t(picture.height) - 1);
    const float across = float(x - double(left)), down = float(y - double(top));
    SeenLight out;
    const auto add = [&](std::size_t column, std::size_t row, float weight) {
        const std::size_t at = row * width + column;
        out.radiance += weight * picture.radiance[at];
        if (picture.at_least[at]) out.uncertain += weight * maskedBy(picture.radiance[at], picture.at_least[at]);
        if (picture.at_most[at] == 7) out.dark += weight;
    };
    add(left, top, (1 - across) * (1 - down));
    add(right, top, across * (1 - down));
    add(left, bottom, (1 - across) * down);
    add(right, bottom, across * down);
    out.weight = 1;
    return out;
}

std::optional<Vec3d> groundBelow(Ground ground, Vec3d from, Vec3d direction) {
    constexpr double kLevel = 1e-9;
    if (ground == Ground::kNone || !(direction.z < -kLevel)) return std::nullopt;
    const Vec3d place = from - (from.z / direction.z) * direction;
    return Vec3d{place.x, place.y, 0};
}

Panorama paintPanorama(int width, int samples, int threads, const std::function<SeenLight(Vec3d)>& look) {
    Panorama p = makePanorama(width);
    const auto paint = [&](std::size_t row, std::size_t column) {
        LightSum sum;
        int seen = 0;
        for (int j = 0; j < samples; ++j)
            for (int i = 0; i < samples; ++i) {
                const double u = (double(column) + (i + 0.5) / samples) / p.width;
                const double v = (double(row) + (j + 0.5) / samples) / p.height;
                const SeenLight one = look(markerDirection(latLongDirection(u, v)));
                sum.add(one);
                seen += one.weight > 0;
            }
        if (seen == 0) return;
        const std::size_t pixel = row * std::size_t(p.width) + column;
        p.radiance[pixel] = toFloat(sum.radiance / sum.weight);
        p.uncertain[pixel] = toFloat(sum.uncertain / sum.weight);
        p.dark[pixel] = float(sum.dark / sum.weight);
        p.seen[pixel] = float(seen) / float(samples * samples);
    };
    parallelFor(std::size_t(p.height), threads, [&](std::size_t row) {
        throwIfInterrupted();
        for (std::size_t column = 0; column < std::size_t(p.width); ++column) paint(row, column);
    });
    return p;
}

}  // namespace penumbra
