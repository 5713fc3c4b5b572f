#include "sh/pinhole_camera.h"

#include <algorithm>
#include <initializer_list>

namespace penumbra {

namespace {

bool allFinite(std::initializer_list<double> numbers) {
    return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
}

// The radius at z = 1 that the lens shows as `r`, and how fast it grows there.
double distortedRadius(const PinholeCamera& camera, double r) {
    const double s = r * r;
    return r * (1 + s * (camera.k1 + s * camera.k2));
}
double radiusSlope(const PinholeCamera& camera, double r) {
    const double s = r * r;
    return 1 + s * (3 * camera.k1 + 5 * s * camera.k2);
}

// Newton's method from `shown` itself. Within the picture the slope is above 0 (findProblem()); outside of it a slope
// that vanishes must not throw the step away.
double undistortedRadius(const PinholeCamera& camera, double shown) {
    double r = shown;
    for (int step = 0; step < 20; ++step) {
        const double change = (distortedRadius(camera, r) - shown) / std::max(radiusSlope(camera, r), 0.1);
        r -= change;
        if (std::abs(change) <= 1e-12 * (1 + r)) break;
    }
    return r;
}

double farthestCorner(const PinholeCamera& camera) {
    double most = 0;
    for (double x : {-0.5, camera.width - 0.5})
        for (double y : {-0.5, camera.height - 0.5})
            most = std::max(most, std::hypot((x - camera.cx) / camera.f, (y - camera.cy) / camera.f));
    return most;
}

// Whether every place of the picture is seen: the shown radius grows from the middle to beyond the farthest corner.
bool lensFolds(const PinholeCamera& camera) {
    if (camera.k1 == 0 && camera.k2 == 0) return false;
    const double corner = farthestCorner(camera);
    for (double r = 0, step = corner / 256; distortedRadius(camera, r) < corner; r += step)
        if (radiusSlope(camera, r) <= 0 || r > 16 * corner) return true;
    return false;
}

}  // namespace

Vec3d CameraPose::place() const { return -(transposed(rotation) * translation); }

std::string findProblem(const PinholeCamera& camera) {
    if (!allFinite({camera.f, camera.cx, camera.cy, camera.k1, camera.k2})) return "has a number that is not finite";
    if (camera.width < 1 || camera.height < 1) return "has no pixels";
    if (camera.f <= 0) return "has a focal length that is not above 0";
    if (lensFolds(camera)) return "has a lens whose k1 and k2 fold the picture before its farthest corner";
    return "";
}

std::string findProblem(const CameraPose& pose) {
    const auto& m = pose.rotation.m;
    if (!std::ranges::all_of(m, [](double x) { return std::isfinite(x); }) ||
        !allFinite({pose.translation.x, pose.translation.y, pose.translation.z}))
        return "has a number that is not finite";
    const Mat3d product = pose.rotation * transposed(pose.rotation);
    double worst = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) worst = std::max(worst, std::abs(product(i, j) - (i == j ? 1 : 0)));
    const double determinant = dot(cross(Vec3d{m[0], m[1], m[2]}, Vec3d{m[3], m[4], m[5]}), Vec3d{m[6], m[7], m[8]});
    if (!(worst <= 1e-3) || determinant < 0) return "has an R that is not a rotation";
    return "";
}

std::optional<PixelPoint> project(const PinholeCamera& camera, Vec3d point) {
    if (!(point.z > 0)) return std::nullopt;
    const double x = point.x / point.z, y = point.y / point.z, s = x * x + y * y;
    const double lens = 1 + s * (camera.k1 + s * camera.k2);
    return PixelPoint{camera.cx + camera.f * x * lens, camera.cy + camera.f * y * lens};
}

Vec3d viewRay(const PinholeCamera& camera, PixelPoint pixel) {
    const double x = (pixel.x - camera.cx) / camera.f, y = (pixel.y - camera.cy) / camera.f;
    const double shown = std::hypot(x, y);
    const double scale = shown > 0 ? undistortedRadius(camera, shown) / shown : 1;
    return normalized(Vec3d{x * scale, y * scale, 1});
}

}  // namespace penumbra
