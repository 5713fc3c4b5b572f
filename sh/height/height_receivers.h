#pragma once
// The points of a height field that look for their horizons, every `step` points both ways, and which of them have to
// look again.
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

    // The two lines of an axis around a point, and how far it is from the first.
    void around(int axis, int at, std::size_t& low, std::size_t& high, float& share) const;

private:
    HeightGrid grid_;
    int step_;
    std::array<std::vector<int>, 2> lines_;
    std::vector<std::uint8_t> awake_;  // [rows, columns]

    void wakeBox(double row0, double row1, double column0, double column1);
};

}  // namespace penumbra
