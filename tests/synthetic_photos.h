#pragma once
// Photographs that tests make of lights with a formula.
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/capture/posed_picture.h"
#include "sh/light/mirror_ball.h"
#include "sh/sh_basis.h"

namespace penumbra {

// The pose of a camera at `eye` that looks at `target`, in the marker's frame, and is level.
inline CameraPose lookingAt(Vec3d eye, Vec3d target) {
    const Vec3d forward = normalized(target - eye);
    const Vec3d right = normalized(cross(forward, std::abs(forward.z) < 0.99 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0}));
    const Mat3d rotation = fromRows(right, cross(forward, right), forward);
    return {rotation, -(rotation * eye)};
}

using SeenFrom = std::function<Vec3d(Vec3d eye, Vec3d ray)>;  // radiance

// A picture whose pixels are means of samples^2 rays.
inline PosedPicture photograph(const PinholeCamera& camera, const CameraPose& pose, int samples, const SeenFrom& look) {
    PosedPicture out{{camera.width, camera.height, {}, {}, {}}, camera, pose};
    const Mat3d to_marker = transposed(pose.rotation);
    const Vec3d eye = pose.place();
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            Vec3d sum;
            for (int j = 0; j < samples; ++j)
                for (int i = 0; i < samples; ++i) {
                    const PixelPoint at{x + (i + 0.5) / samples - 0.5, y + (j + 0.5) / samples - 0.5};
                    sum += look(eye, to_marker * viewRay(camera, at));
                }
            out.picture.radiance.push_back(toFloat(sum / double(samples * samples)));
        }
    out.picture.at_least.resize(out.picture.radiance.size());
    out.picture.at_most.resize(out.picture.radiance.size());
    return out;
}

// Adds a mirror ball to a light: rays that hit the ball see the mirrored direction.
inline SeenFrom withBall(const MirrorBall& ball, const SeenFrom& light) {
    return [=](Vec3d eye, Vec3d ray) {
        const std::optional<Vec3d> mirrored = reflectedDirection(ball, eye, ray);
        if (!mirrored) return light(eye, ray);
        // The point of the ball: the ray's length s follows from the normal n = (eye + s ray - center) / radius.
        const Vec3d center = ball.center - eye;
        const double along = dot(ray, center);
        const double s = along - std::sqrt(along * along - dot(center, center) + ball.radius * ball.radius);
        return ball.reflectance * light(eye + s * ray, *mirrored);
    };
}

// The codes of a picture at an exposure.
inline TexturePicture developed(const RadiancePicture& picture, double exposure, const CameraResponse& response) {
    TexturePicture out{picture.width, picture.height, {}};
    for (const Vec3& radiance : picture.radiance)
        for (int c = 0; c < 3; ++c)
            out.rgb.push_back(std::uint8_t(std::lround(codeOf(response, c, radiance[c] * float(exposure)))));
    return out;
}

// SH of a panorama in the marker's frame, [order^2, 3], for tests whose lights are in that frame.
inline std::vector<double> projectedInMarkerFrame(const Panorama& p, int order) {
    std::vector<double> sh(3 * std::size_t(order * order)), basis(std::size_t(order * order));
    for (int y = 0; y < p.height; ++y)
        for (int x = 0; x < p.width; ++x) {
            evalBasis(order, markerDirection(latLongDirection((x + 0.5) / p.width, (y + 0.5) / p.height)), basis);
            const Vec3 light = p.radiance[std::size_t(y) * std::size_t(p.width) + std::size_t(x)];
            for (std::size_t i = 0; i < basis.size(); ++i)
                for (int c = 0; c < 3; ++c)
                    sh[3 * i + std::size_t(c)] += steradiansOfRow(p, y) * basis[i] * double(light[c]);
        }
    return sh;
}

// The lights of tests/golden/light_capture.json, by direction.
inline Vec3d goldenLight(const std::string& name, Vec3d d) {
    const auto lobe = [&](Vec3d axis) { return dot(d, normalized(axis)); };
    Vec3d out;
    const double s[] = {0.6, 0.8, 1}, q[] = {1, 0.9, 0.75}, a[] = {1, 0.9, 0.7}, b[] = {0.4, 0.6, 1},
                 sunset[] = {1, 0.5, 0.25};
    for (int c = 0; c < 3; ++c) {
        if (name == "sky and sun")
            out[c] = 0.35 + 0.5 * std::sqrt(std::max(d.z, 0.0)) * s[c] +
                     6 * q[c] * std::exp(60 * (lobe({0.3, -0.5, 0.81}) - 1));
        else if (name == "room")
            out[c] = 0.15 + 3 * a[c] / (1 + std::exp(-40 * (lobe({1, 0.2, 0.4}) - 0.93))) +
                     2 * b[c] / (1 + std::exp(-30 * (lobe({-0.6, 0.7, 0.3}) - 0.9)));
        else
            out[c] = 0.2 + 0.8 * sunset[c] * std::exp(-4 * std::abs(d.z - 0.05)) *
                               (1 + std::pow(std::max(lobe({0.7, 0.7, 0.1}), 0.0), 4));
    }
    return out;
}

}  // namespace penumbra
