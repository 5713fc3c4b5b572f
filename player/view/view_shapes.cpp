#include "player/view/view_shapes.h"

#include <algorithm>
#include <numbers>

#include "sh/sh_basis.h"

namespace penumbra {

std::vector<Vec3> radianceFrom(const LightView& light, const Mat3& rotation, std::span<const Vec3> directions) {
    const Mat3 back = transposed(rotation);
    const std::size_t count = std::size_t(coefficientCount(light.order));
    std::vector<float> basis(count);
    std::vector<Vec3> radiance;
    for (const Vec3& direction : directions) {
        evalBasis(light.order, back * direction, basis);
        Vec3 sum;
        for (std::size_t i = 0; i < count; ++i)
            sum += Vec3{light.sh[3 * i], light.sh[3 * i + 1], light.sh[3 * i + 2]} * basis[i];
        radiance.push_back({std::max(sum.x, 0.0f), std::max(sum.y, 0.0f), std::max(sum.z, 0.0f)});
    }
    return radiance;
}

// The clamped cosine about s is zonal: E(s) = sum over l of A_l sum over m of L_lm y_lm(s), with A = pi, 2 pi / 3, pi
// / 4, 0, -pi / 24, 0, pi / 64, 0 (Ramamoorthi and Hanrahan 2001, eq 8).
Vec3 irradianceFromAbove(const LightView& light, const Mat3& rotation) {
    constexpr double kPi = std::numbers::pi;
    constexpr double kCosine[kMaxOrder] = {kPi, 2 * kPi / 3, kPi / 4, 0, -kPi / 24, 0, kPi / 64, 0};
    std::vector<float> basis(std::size_t(coefficientCount(light.order)));
    evalBasis(light.order, transposed(rotation) * Vec3{0, 1, 0}, basis);
    Vec3 sum;
    for (std::size_t i = 0; i < basis.size(); ++i)
        sum += Vec3{light.sh[3 * i], light.sh[3 * i + 1], light.sh[3 * i + 2]} *
               (basis[i] * float(kCosine[bandOfIndex(int(i))]));
    return {std::max(sum.x, 0.0f), std::max(sum.y, 0.0f), std::max(sum.z, 0.0f)};
}

Shape groundPlane(const BoundingBox& box, Vec3 light) {
    constexpr int kTiles = 24;
    const float tile = float(box.radius()) / 3;
    const Vec3 middle = (box.low + box.high) * 0.5f;
    Shape ground;
    for (int row = 0; row < kTiles; ++row)
        for (int column = 0; column < kTiles; ++column) {
            const auto first = std::uint32_t(ground.positions.size());
            for (const auto& [x, z] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
                ground.positions.push_back({middle.x + tile * float(column + x - kTiles / 2), box.low.y,
                                            middle.z + tile * float(row + z - kTiles / 2)});
                ground.values.push_back(light * ((row + column) % 2 == 0 ? 0.25f : 0.2f));
            }
            ground.triangles.insert(ground.triangles.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
        }
    return ground;
}

}  // namespace penumbra
