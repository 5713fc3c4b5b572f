#include "sh/height/height_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

void include(TexelBox& box, const TexelBox& other) {
    if (other.empty()) return;
    if (box.empty())
        box = other;
    else
        box = {std::min(box.first_row, other.first_row), std::min(box.first_column, other.first_column),
               std::max(box.end_row, other.end_row), std::max(box.end_column, other.end_column)};
}

namespace {

std::string outside(const char* field, double value, double least, double most) {
    return std::string(field) + " is " + std::to_string(value) + ", allowed are " + std::to_string(least) + " to " +
           std::to_string(most);
}

void include(TexelBox& box, int row, int column) { penumbra::include(box, TexelBox{row, column, row + 1, column + 1}); }

int half(int count) { return (count + 1) / 2; }

}  // namespace

std::string findProblem(const HeightGrid& grid) {
    for (const auto& [name, side] : {std::pair{"rows", grid.rows}, {"columns", grid.columns}})
        if (side < 1 || side > kMaxHeightSide) return outside(name, side, 1, kMaxHeightSide);
    if (grid.size() > kMaxHeightTexels)
        return outside("rows times columns", double(grid.size()), 1, double(kMaxHeightTexels));
    for (const auto& [name, cell] : {std::pair{"cell (rows)", grid.cell_x}, {"cell (columns)", grid.cell_y}})
        if (!(cell >= kMinCell && cell <= kMaxCell))
            return outside(name, double(cell), double(kMinCell), double(kMaxCell));
    return "";
}

HeightField::HeightField(const HeightGrid& grid, std::span<const float> heights) : grid_(grid) {
    assert(findProblem(grid).empty() && heights.size() == grid.size());
    HeightLevel level{grid.rows, grid.columns, 0};
    levels_.push_back(level);
    while (level.rows > 1 || level.columns > 1) {
        level.first += std::size_t(level.rows) * std::size_t(level.columns);
        level.rows = half(level.rows);
        level.columns = half(level.columns);
        levels_.push_back(level);
    }
    // No maximum is this low, so that the first update writes all of them.
    all_heights_.assign(level.first + 1, -2 * kMaxElevation);
    changed_.resize(levels_.size());
    set(heights);
}

std::span<const TexelBox> HeightField::set(const TexelBox& box, std::span<const float> heights) {
    const int width = box.end_column - box.first_column;
    assert(box.first_row >= 0 && box.first_column >= 0 && box.end_row <= grid_.rows &&
           box.end_column <= grid_.columns &&
           heights.size() == std::size_t(box.end_row - box.first_row) * std::size_t(width));
    std::ranges::fill(changed_, TexelBox{});
    for (int r = box.first_row; r < box.end_row; ++r) {
        float* const row = all_heights_.data() + std::size_t(r) * std::size_t(grid_.columns);
        const float* const from = heights.data() + std::size_t(r - box.first_row) * std::size_t(width);
        // From the first to the last that is another one.
        int first = 0, last = width;
        while (first < width && row[box.first_column + first] == from[first]) ++first;
        while (last > first && row[box.first_column + last - 1] == from[last - 1]) --last;
        if (first == last) continue;
        std::copy(from + first, from + last, row + box.first_column + first);
        include(changed_[0], r, box.first_column + first);
        include(changed_[0], r, box.first_column + last - 1);
    }
    for (std::size_t l = 1; l < levels_.size() && !changed_[l - 1].empty(); ++l) {
        const HeightLevel &below = levels_[l - 1], &level = levels_[l];
        const TexelBox& wake = changed_[l - 1];
        const float* const from = all_heights_.data() + below.first;
        for (int r = wake.first_row / 2; r < half(wake.end_row); ++r) {
            const float* const upper = from + std::size_t(2 * r) * std::size_t(below.columns);
            const float* const lower = 2 * r + 1 < below.rows ? upper + below.columns : upper;
            float* const out = all_heights_.data() + level.first + std::size_t(r) * std::size_t(level.columns);
            for (int c = wake.first_column / 2; c < half(wake.end_column); ++c) {
                const int left = 2 * c, right = std::min(left + 1, below.columns - 1);
                const float most = std::max(std::max(upper[left], upper[right]), std::max(lower[left], lower[right]));
                if (out[c] == most) continue;
                out[c] = most;
                include(changed_[l], r, c);
            }
        }
    }
    return changed_;
}

int HeightField::neighbour(int at, int step, int count) const {
    if (grid_.border == HeightBorder::kPeriodic) return ((at + step) % count + count) % count;
    return std::clamp(at + step, 0, count - 1);
}

namespace {

// The two points of an axis around a place, and how far it is from the first.
template <class Real>
struct Around {
    int low, high;
    Real share;
};

template <class Real>
Around<Real> around(Real x, int count, bool wraps) {
    if (wraps) x -= Real(count) * std::floor(x / Real(count));
    // What is no number, and what rounding leaves outside.
    x = x > 0 ? std::min(x, Real(wraps ? count : count - 1)) : 0;
    const int low = std::min(int(x), count - 1);
    return {low, low + 1 < count ? low + 1 : wraps ? 0 : low, x - Real(low)};
}

}  // namespace

float HeightField::at(float row, float column) const {
    const bool wraps = grid_.border == HeightBorder::kPeriodic;
    const auto [r0, r1, fr] = around(row, grid_.rows, wraps);
    const auto [c0, c1, fc] = around(column, grid_.columns, wraps);
    const float upper = height(r0, c0) + fc * (height(r0, c1) - height(r0, c0)),
                lower = height(r1, c0) + fc * (height(r1, c1) - height(r1, c0));
    return upper + fr * (lower - upper);
}

double HeightField::onTriangles(double row, double column) const {
    const bool wraps = grid_.border == HeightBorder::kPeriodic;
    const auto [r0, r1, fr] = around(row, grid_.rows, wraps);
    const auto [c0, c1, fc] = around(column, grid_.columns, wraps);
    const double right = height(r0, c1), below = height(r1, c0);
    if (fr + fc <= 1) {
        const double corner = height(r0, c0);
        return corner + fr * (below - corner) + fc * (right - corner);
    }
    const double corner = height(r1, c1);
    return corner + (1 - fr) * (right - corner) + (1 - fc) * (below - corner);
}

Vec3 HeightField::normal(int row, int column) const {
    const bool wraps = grid_.border == HeightBorder::kPeriodic;
    const int r0 = neighbour(row, -1, grid_.rows), r1 = neighbour(row, 1, grid_.rows),
              c0 = neighbour(column, -1, grid_.columns), c1 = neighbour(column, 1, grid_.columns);
    // One-sided where an edge cuts the difference short.
    const float steps_x = wraps ? 2 : float(std::max(r1 - r0, 1)), steps_y = wraps ? 2 : float(std::max(c1 - c0, 1));
    const float dx = (height(r1, column) - height(r0, column)) / (steps_x * grid_.cell_x),
                dy = (height(row, c1) - height(row, c0)) / (steps_y * grid_.cell_y),
                size = std::sqrt(1 + dx * dx + dy * dy);
    return {-dx / size, -dy / size, 1 / size};
}

}  // namespace penumbra
