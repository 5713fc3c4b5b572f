#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Holds points in cubes of side `cell`. A look-up visits the cubes that the ball around a point reaches, which mostly
// is one.
class PointGrid {
public:
    PointGrid(double radius, double cell) : radius_(radius), cell_(cell) {}

    // Points are numbered from 0 and come in order.
    void add(Vec3d p, std::uint32_t point) {
        std::uint32_t& last = last_of_cell_.try_emplace(keyOf(p), kNone).first->second;
        before_.push_back(last);
        last = point;
    }

    template <class Accept>  // the first added point that `accept` takes, or none
    std::uint32_t find(Vec3d p, const Accept& accept) const {
        std::uint32_t best = kNone;
        const Vec3d reach{radius_, radius_, radius_};
        const Key low = keyOf(p - reach), high = keyOf(p + reach);
        for (auto x = low[0]; x <= high[0]; ++x)
            for (auto y = low[1]; y <= high[1]; ++y)
                for (auto z = low[2]; z <= high[2]; ++z) {
                    const auto cell = last_of_cell_.find({x, y, z});
                    if (cell == last_of_cell_.end()) continue;
                    for (std::uint32_t point = cell->second; point != kNone; point = before_[point])
                        if (point < best && accept(point)) best = point;
                }
        return best;
    }

    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

private:
    using Key = std::array<std::int64_t, 3>;
    struct Hash {
        std::size_t operator()(const Key& k) const {
            return std::size_t(k[0]) * 73856093u ^ std::size_t(k[1]) * 19349663u ^ std::size_t(k[2]) * 83492791u;
        }
    };
    Key keyOf(Vec3d p) const {
        // Hostile files have cells that are too small for their places: what is far out shares a cell.
        constexpr double kFarthest = 4e18;
        const auto index = [&](double v) {
            const double i = std::floor(v / cell_);
            return std::int64_t(i < kFarthest ? (i > -kFarthest ? i : -kFarthest) : kFarthest);
        };
        return {index(p.x), index(p.y), index(p.z)};
    }

    double radius_, cell_;
    std::unordered_map<Key, std::uint32_t, Hash> last_of_cell_;
    std::vector<std::uint32_t> before_;  // [points] the point before it in its cube, or kNone
};

}  // namespace penumbra
