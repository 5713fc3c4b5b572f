#include "sh/height/height_brush.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

TexelBox strokeHeights(const HeightField& field, const HeightStroke& stroke, std::vector<float>& heights) {
    heights.clear();
    const HeightGrid& grid = field.grid();
    if (!(stroke.radius > 0) || !std::isfinite(stroke.row + stroke.column + stroke.radius + stroke.rise)) return {};
    const auto lowest = [](float at, float reach, int count) {
        return int(std::clamp(std::ceil(double(at) - double(reach)), 0.0, double(count)));
    };
    const auto end = [](float at, float reach, int count) {
        return int(std::clamp(std::floor(double(at) + double(reach)) + 1, 0.0, double(count)));
    };
    const float down = stroke.radius / grid.cell_x, across = stroke.radius / grid.cell_y;
    const TexelBox box{lowest(stroke.row, down, grid.rows), lowest(stroke.column, across, grid.columns),
                       end(stroke.row, down, grid.rows), end(stroke.column, across, grid.columns)};
    if (box.empty()) return {};
    for (int r = box.first_row; r < box.end_row; ++r)
        for (int c = box.first_column; c < box.end_column; ++c) {
            const float x = (float(r) - stroke.row) / down, y = (float(c) - stroke.column) / across,
                        left = std::max(1 - x * x - y * y, 0.0f);
            const float height = field.heights()[std::size_t(r) * std::size_t(grid.columns) + std::size_t(c)];
            heights.push_back(std::clamp(height + stroke.rise * left * left, -kMaxElevation, kMaxElevation));
        }
    return box;
}

}  // namespace penumbra
