#include "sh/height/height_receivers.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

HeightReceivers::HeightReceivers(const HeightGrid& grid, int step) : grid_(grid), step_(step) {
    for (const auto& [axis, count] : {std::pair{0, grid.rows}, {1, grid.columns}}) {
        std::vector<int>& lines = lines_[std::size_t(axis)];
        for (int at = 0; at < count; at += step) lines.push_back(at);
        // A periodic field goes on with its first line.
        if (lines.back() != count - 1 && grid.border != HeightBorder::kPeriodic) lines.push_back(count - 1);
    }
    awake_.assign(lines_[0].size() * lines_[1].size(), 1);
    stale_ = changed_ = looks_ = awake_;
}

void HeightReceivers::wakeAll() {
    std::ranges::fill(awake_, std::uint8_t(1));
    std::ranges::fill(stale_, std::uint8_t(1));
    std::ranges::fill(looks_, std::uint8_t(1));
}

bool HeightReceivers::isStale(std::size_t row, std::size_t column) const {
    const auto after = [](std::size_t line, std::size_t count) { return line + 1 < count ? line + 1 : 0; };
    const std::size_t below = after(row, rows()), right = after(column, columns());
    return stale_[row * columns() + column] || changed_[row * columns() + column] ||
           changed_[row * columns() + right] || changed_[below * columns() + column] ||
           changed_[below * columns() + right];
}

void HeightReceivers::freshen() {
    std::ranges::fill(stale_, std::uint8_t(0));
    std::ranges::fill(changed_, std::uint8_t(0));
    std::ranges::fill(looks_, std::uint8_t(0));
}

// Makes cells stale that have one of these receivers at a corner: those and the ones before them, round the ends.
void HeightReceivers::spoil(std::size_t first_row, std::size_t first_column, std::size_t end_row,
                            std::size_t end_column) {
    const auto spoilRow = [&](std::size_t row) {
        std::uint8_t* const cells = &stale_[row * columns()];
        std::fill(cells + first_column, cells + end_column, std::uint8_t(1));
        cells[first_column > 0 ? first_column - 1 : columns() - 1] = 1;
    };
    spoilRow(first_row > 0 ? first_row - 1 : rows() - 1);
    for (std::size_t row = first_row; row < end_row; ++row) spoilRow(row);
}

std::size_t HeightReceivers::awake() const { return std::size_t(std::ranges::count(awake_, 1)); }

// Wakes receivers in a box of places, which may lie beyond the border, and notes the cells that have some of them.
void HeightReceivers::wakeBox(double row0, double row1, double column0, double column1) {
    const auto range = [&](std::size_t axis, double low, double high) {
        const auto begin = lines_[axis].begin();
        const auto first = std::lower_bound(begin, lines_[axis].end(), int(std::ceil(std::max(low, -1e6))));
        const auto last = std::upper_bound(first, lines_[axis].end(), int(std::floor(std::min(high, 1e6))));
        return std::pair(std::size_t(first - begin), std::size_t(last - begin));
    };
    const bool wraps = grid_.border == HeightBorder::kPeriodic;
    // The whole field where a box is as wide as that, else the box and its images on either side.
    const auto shifts = [&](double low, double high, int count) {
        if (!wraps) return std::pair(0, 0);
        return std::pair(int(std::ceil((0 - high) / count)), int(std::floor((count - low) / count)));
    };
    const auto [r0, r1] = shifts(row0, row1, grid_.rows);
    const auto [c0, c1] = shifts(column0, column1, grid_.columns);
    for (int i = r0; i <= r1; ++i)
        for (int j = c0; j <= c1; ++j) {
            const auto [first, end] = range(0, row0 + double(i) * grid_.rows, row1 + double(i) * grid_.rows);
            const auto [left, right] =
                range(1, column0 + double(j) * grid_.columns, column1 + double(j) * grid_.columns);
            for (std::size_t r = first; r < end && left < right; ++r)
                std::fill_n(awake_.begin() + std::ptrdiff_t(r * columns() + left), right - left, std::uint8_t(1));
            // Cells begin at their first line, and the one before the box ends in it.
            const std::size_t before = std::max(left, std::size_t(1)) - 1;
            for (std::size_t r = std::max(first, std::size_t(1)) - 1; r < end && before < right; ++r)
                std::fill_n(looks_.begin() + std::ptrdiff_t(r * columns() + before), right - before, std::uint8_t(1));
        }
}

void HeightReceivers::wake(const HeightField& field, const HorizonTaps& taps, std::span<const TexelBox> changed) {
    constexpr double kFar = 1e6;  // beyond a clamped border the edge goes on for ever
    if (changed.empty() || changed[0].empty()) return;
    if (changed[0] == TexelBox{0, 0, grid_.rows, grid_.columns}) return wakeAll();
    const bool clamps = grid_.border == HeightBorder::kClamped;
    // Normals and own heights, of receivers and of the points between them.
    const auto cellOf = [&](int at) { return std::size_t(std::max(at, 0) / step_); };
    const auto cellAfter = [&](int at, int axis) {
        return std::min(std::size_t(at / step_) + 2, lines_[std::size_t(axis)].size());
    };
    spoil(cellOf(changed[0].first_row - 1), cellOf(changed[0].first_column - 1), cellAfter(changed[0].end_row, 0),
          cellAfter(changed[0].end_column, 1));
    // Normals at the first line of a periodic field take heights of the last one.
    const bool at_end = changed[0].end_row == grid_.rows || changed[0].end_column == grid_.columns;
    if (at_end && grid_.border == HeightBorder::kPeriodic) std::ranges::fill(stale_, std::uint8_t(1));
    wakeBox(changed[0].first_row - 1, changed[0].end_row, changed[0].first_column - 1, changed[0].end_column);
    for (const HorizonTap& tap : taps.taps) {
        const TexelBox& box = changed[std::size_t(tap.level)];
        if (box.empty()) continue;
        const HeightLevel& level = field.levels()[std::size_t(tap.level)];
        // Places of level 0 whose bilinear sample has a point of the box, a little more because of rounding.
        const double scale = std::exp2(tap.level), margin = 0.02;
        const auto low = [&](int first) { return clamps && first == 0 ? -kFar : (first - 0.5) * scale - 0.5 - margin; };
        const auto high = [&](int end, int count) {
            return clamps && end == count ? kFar : (end + 0.5) * scale - 0.5 + margin;
        };
        wakeBox(low(box.first_row) - double(tap.row), high(box.end_row, level.rows) - double(tap.row),
                low(box.first_column) - double(tap.column), high(box.end_column, level.columns) - double(tap.column));
    }
}

void HeightReceivers::takeAwake(std::vector<std::uint32_t>& receivers) {
    receivers.clear();
    for (std::size_t i = 0; i < awake_.size(); ++i)
        if (takeAwake(i)) receivers.push_back(std::uint32_t(i));
}

void HeightReceivers::takeLooking(std::vector<std::uint32_t>& cells) {
    cells.clear();
    for (std::size_t i = 0; i < looks_.size(); ++i)
        if (looks_[i]) cells.push_back(std::uint32_t(i));
    std::ranges::fill(looks_, std::uint8_t(0));
}

void HeightReceivers::around(int axis, int at, std::size_t& low, std::size_t& high, float& share) const {
    const std::vector<int>& lines = lines_[std::size_t(axis)];
    low = std::size_t(at / step_);
    if (low + 1 == lines.size()) {
        // The last line, or beyond it: a periodic field goes on with its first one.
        const int gap = (axis == 0 ? grid_.rows : grid_.columns) - lines[low];
        high = grid_.border == HeightBorder::kPeriodic ? 0 : low;
        share = float(at - lines[low]) / float(std::max(gap, 1));
        return;
    }
    high = low + 1;
    share = float(at - lines[low]) / float(lines[high] - lines[low]);
}

}  // namespace penumbra
