#include "formats/capture/ball_panorama.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace penumbra {

namespace {

constexpr int kOutlinePoints = 64;

// The direction of a ray from the camera that touches the ball.
Vec3d touchingRay(Vec3d axis, double k, double turn) {
    const Vec3d side = normalized(cross(axis, std::abs(axis.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}));
    const Vec3d other = cross(axis, side);
    return std::sqrt(1 - k * k) * -axis + k * (std::cos(turn) * side + std::sin(turn) * other);
}

}  // namespace

BallOutline outlineOf(const PosedPicture& shot, const MirrorBall& ball) {
    const Vec3d eye = shot.pose.place(), to_eye = eye - ball.center;
    const double distance = length(to_eye);
    if (!(distance > ball.radius * (1 + 1e-6))) throw std::invalid_argument("the camera stands inside of the ball");
    const std::optional<PixelPoint> middle = pixelOfPlace(shot, ball.center);
    if (!middle) throw std::invalid_argument("the ball is out of the picture");
    BallOutline outline;
    int inside = 0;
    for (int i = 0; i < kOutlinePoints; ++i) {
        const double turn = 2 * std::numbers::pi * i / kOutlinePoints;
        const std::optional<PixelPoint> pixel =
            pixelOfRay(shot, touchingRay(to_eye / distance, ball.radius / distance, turn));
        if (!pixel) continue;
        ++inside;
        outline.radius += std::hypot(pixel->x - middle->x, pixel->y - middle->y);
    }
    outline.in_picture = double(inside) / kOutlinePoints;
    const double k = ball.radius / distance;
    outline.radius = inside > 0 ? outline.radius / inside : shot.camera.f * k / std::sqrt(1 - k * k);
    return outline;
}

Panorama panoramaOfBall(const PosedPicture& shot, const MirrorBall& ball, const BallPanoramaOptions& options) {
    const double radius = outlineOf(shot, ball).radius;
    const BallView view(ball, shot.pose.place(), std::asin(std::clamp(1 - kOutlineMargin / radius, 0.1, 1.0)));
    const float gain = float(1 / ball.reflectance);
    return paintPanorama(options.width, options.samples, options.threads, [&](Vec3d direction) -> SeenLight {
        const std::optional<Vec3d> place = groundBelow(options.ground, options.at, direction);
        const std::optional<Vec3d> ray = place ? view.rayToPlace(*place) : view.rayToDirection(direction);
        if (!ray) return {};
        const std::optional<PixelPoint> pixel = pixelOfRay(shot, *ray);
        if (!pixel) return {};
        SeenLight seen = lightAt(shot.picture, *pixel);
        seen.radiance = gain * seen.radiance;
        seen.uncertain = gain * seen.uncertain;
        return seen;
    });
}

}  // namespace penumbra
