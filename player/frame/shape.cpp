#include "player/frame/shape.h"

#include <cmath>
#include <numbers>

namespace penumbra {

Shape unitSphere(int rings) {
    const int around = 2 * rings;
    Shape sphere;
    for (int ring = 0; ring <= rings; ++ring)
        for (int i = 0; i <= around; ++i) {
            const double polar = std::numbers::pi * ring / rings, azimuth = 2 * std::numbers::pi * i / around;
            sphere.positions.push_back(toFloat(
                Vec3d{std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth)}));
        }
    for (int ring = 0; ring < rings; ++ring)
        for (int i = 0; i < around; ++i) {
            const auto a = std::uint32_t(ring * (around + 1) + i), b = a + std::uint32_t(around + 1);
            sphere.triangles.insert(sphere.triangles.end(), {a, a + 1, b, a + 1, b + 1, b});
        }
    return sphere;
}

}  // namespace penumbra
