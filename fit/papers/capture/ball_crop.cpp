#include "fit/papers/capture/ball_crop.h"

#include <array>
#include <cmath>
#include <numbers>

#include "sh/sh_basis.h"

namespace penumbra {

using std::numbers::pi;

std::optional<CropDirection> cropDirection(CropFormula formula, double u, double v, int width) {
    const double r = std::hypot(u, v), side = 2.0 / width;
    if (r > 1) return std::nullopt;
    const double azimuth = std::atan2(v, u);
    if (formula == CropFormula::kFarBall) return CropDirection{2 * std::asin(r), azimuth, 4 * side * side};
    const double polar = pi * r, sinc = polar < 1e-9 ? 1 : std::sin(polar) / polar;
    return CropDirection{polar, azimuth, pi * pi * side * side * sinc};
}

std::vector<double> projectCrop(const PosedPicture& shot, const MirrorBall& ball, CropFormula formula, int order,
                                int width) {
    const Vec3d to_eye = shot.pose.place() - ball.center, axis = normalized(to_eye);
    const double k = ball.radius / length(to_eye), reach = k / std::sqrt(1 - k * k);
    const Mat3d& r = shot.pose.rotation;
    const Vec3d right = normalized(cross(Vec3d{-r(1, 0), -r(1, 1), -r(1, 2)}, axis)), up = cross(axis, right);
    std::vector<double> sh(3 * std::size_t(coefficientCount(order)));
    std::array<double, coefficientCount(kMaxOrder)> values;
    const auto basis = std::span(values).first(std::size_t(coefficientCount(order)));
    for (int y = 0; y < width; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = (2 * x + 1.0) / width - 1, v = 1 - (2 * y + 1.0) / width;
            const std::optional<CropDirection> crop = cropDirection(formula, u, v, width);
            const std::optional<PixelPoint> pixel = pixelOfRay(shot, reach * (u * right + v * up) - axis);
            if (!crop || !pixel) continue;
            const Vec3d around = std::cos(crop->azimuth) * right + std::sin(crop->azimuth) * up;
            const Vec3d direction = std::cos(crop->polar) * axis + std::sin(crop->polar) * around;
            evalBasis(order, sceneDirection(direction), basis);
            const Vec3d light =
                (crop->steradians / ball.reflectance) * toDouble(lightAt(shot.picture, *pixel).radiance);
            for (std::size_t i = 0; i < basis.size(); ++i)
                for (std::size_t c = 0; c < 3; ++c) sh[3 * i + c] += basis[i] * light[int(c)];
        }
    return sh;
}

}  // namespace penumbra
