#include "player/view/view_shapes.h"

#include <algorithm>

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

GroundTiles groundTiles(std::uint32_t side) {
    constexpr float kShade = 0.8f;  // of every other tile
    const std::uint32_t squares = side - 1, step = std::max(1u, squares / kGroundTiles);
    GroundTiles out;
    for (std::uint32_t row = 0; row < squares; row += step)
        for (std::uint32_t column = 0; column < squares; column += step) {
            const auto first = std::uint32_t(out.vertices.size());
            const std::uint32_t rows = std::min(step, squares - row), columns = std::min(step, squares - column);
            for (std::uint32_t i = 0; i <= rows; ++i)
                for (std::uint32_t j = 0; j <= columns; ++j) {
                    out.vertices.push_back((row + i) * side + column + j);
                    out.shades.push_back((row / step + column / step) % 2 == 0 ? 1 : kShade);
                }
            for (std::uint32_t i = 0; i < rows; ++i)
                for (std::uint32_t j = 0; j < columns; ++j) {
                    const std::uint32_t a = first + i * (columns + 1) + j, b = a + columns + 1;
                    out.triangles.insert(out.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
                }
        }
    return out;
}

}  // namespace penumbra
