#pragma once
// The points of a height field that look for their horizons, every `step` points both ways, which of them have to look
// again, and which points in between show something else then.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/height/horizon.h"

namespace penumbra {

class HeightReceivers {
public:
    // `step` is 1, 2, 4 or 8. At first all are awake.
    HeightReceivers(const HeightGrid& grid, int step);

    int step() const { return step_; }
    // Rows (axis 0) or columns (axis 1) that have receivers.
    std::span<const int> lines(int axis) const { return lines_[std::size_t(axis)]; }
    std::size_t rows() const { return lines_[0].size(); }
    std::size_t columns() const { return lines_[1].size(); }
    std::size_t count() const { return awake_.size(); }
    // The line of an axis at a point, or kNone.
    static constexpr std::size_t kNone = std::size_t(-1);
    std::size_t lineAt(int axis, int at) const {
        const std::vector<int>& lines = lines_[std::size_t(axis)];
        return at % step_ == 0 ? std::size_t(at / step_) : at == lines.back() ? lines.size() - 1 : kNone;
    }

    // Wakes those that look at what HeightField::set() changed. Allocates nothing.
    void wake(const HeightField& field, const HorizonTaps& taps, std::span<const TexelBox> changed);
    void wakeAll();
    std::size_t awake() const;
    // Tells whether a receiver is awake, and puts it to sleep. Different ones may run at once.
    bool takeAwake(std::size_t receiver) {
        const bool awake = awake_[receiver] != 0;
        awake_[receiver] = 0;
        return awake;
    }
    // Lists all that are awake, ascending, and puts them to sleep.
    void takeAwake(std::vector<std::uint32_t>& receivers);
    // Moves the cells with looks() into `cells`, ascending, and clears the mark.
    void takeLooking(std::vector<std::uint32_t>& cells);

    // Call this where a receiver that has looked again sees something else. Different ones may run at once.
    void noteChange(std::size_t receiver) { changed_[receiver] = 1; }
    // Cells lie between four receivers, and point (row, column) is in cell (row / step, column / step). One is stale
    // after a change of what a receiver sees, or of the normals of its points.
    bool isStale(std::size_t row, std::size_t column) const;
    // Tells whether any point of a cell or at its edge may look at something that changed since freshen().
    bool looks(std::size_t row, std::size_t column) const { return looks_[row * columns() + column] != 0; }
    void freshen();

    // The two lines of an axis around a point, and how far it is from the first.
    void around(int axis, int at, std::size_t& low, std::size_t& high, float& share) const;

private:
    HeightGrid grid_;
    int step_;
    std::array<std::vector<int>, 2> lines_;
    std::vector<std::uint8_t> awake_, stale_, changed_, looks_;  // [rows, columns]

    void wakeBox(double row0, double row1, double column0, double column1);
    void spoil(std::size_t first_row, std::size_t first_column, std::size_t end_row, std::size_t end_column);
};

}  // namespace penumbra
