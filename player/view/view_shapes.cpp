#include "player/view/view_shapes.h"

#include <algorithm>

namespace penumbra {

GroundTiles groundTiles(std::uint32_t side) {
    const std::uint32_t squares = side - 1, step = std::max(1u, squares / kGroundTiles);
    GroundTiles out;
    for (std::uint32_t row = 0; row < squares; row += step)
        for (std::uint32_t column = 0; column < squares; column += step) {
            const auto first = std::uint32_t(out.vertices.size());
            const std::uint32_t rows = std::min(step, squares - row), columns = std::min(step, squares - column);
            for (std::uint32_t i = 0; i <= rows; ++i)
                for (std::uint32_t j = 0; j <= columns; ++j) {
                    out.vertices.push_back((row + i) * side + column + j);
                    out.shades.push_back(kTileShades[(row / step + column / step) % 2]);
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
