#include "player/view/view_brush.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

// The part of a ray over the field, from its first to its last distance; none: the first is beyond the last.
struct OverField {
    double first = 0, last = 1e9;
};

void clipTo(OverField& over, double origin, double way, double low, double high) {
    if (way == 0) {
        if (origin < low || origin > high) over.last = -1;
        return;
    }
    const double a = (low - origin) / way, b = (high - origin) / way;
    over.first = std::max(over.first, std::min(a, b));
    over.last = std::min(over.last, std::max(a, b));
}

OverField overField(const GroundHeights& heights, Vec3d origin, Vec3d way) {
    const HeightGrid& grid = heights.field().grid();
    const Vec3d low = toDouble(heights.corner());
    const auto [least, most] = std::ranges::minmax(heights.field().heights());
    OverField over;
    clipTo(over, origin.x, way.x, low.x, low.x + double(grid.cell_y) * (grid.columns - 1));
    clipTo(over, origin.z, way.z, low.z, low.z + double(grid.cell_x) * (grid.rows - 1));
    clipTo(over, origin.y, way.y, low.y + double(least) - 1e-3, low.y + double(most) + 1e-3);
    return over;
}

}  // namespace

std::optional<Vec3d> pointOnField(const GroundHeights& heights, Vec3d origin, Vec3d way) {
    constexpr int kMaxStrokeSteps = 8192, kHalvings = 30;
    const HeightGrid& grid = heights.field().grid();
    const OverField over = overField(heights, origin, way);
    if (!(over.first <= over.last)) return std::nullopt;
    const auto above = [&](double t) {
        const Vec3d p = origin + way * t;
        return p.y - heights.heightAt(p.x, p.z);
    };
    // Half a point at a time, then halves of the step that goes below the field.
    const double across = std::max(std::abs(way.x) / double(grid.cell_y), std::abs(way.z) / double(grid.cell_x));
    const double step =
        std::max(across > 0 ? 0.5 / across : over.last - over.first, (over.last - over.first) / kMaxStrokeSteps);
    if (above(over.first) < 0) return std::nullopt;
    for (double t = over.first; t <= over.last; t += step) {
        double high = t, low = std::min(t + step, over.last);
        if (above(low) > 0) {
            if (step <= 0) break;
            continue;
        }
        for (int i = 0; i < kHalvings; ++i) {
            const double middle = 0.5 * (high + low);
            (above(middle) > 0 ? high : low) = middle;
        }
        return origin + way * low;
    }
    return std::nullopt;
}

std::optional<GroundStroke> strokeUnder(const Scene& scene, const ViewState& state, const Rectangle& picture, double x,
                                        double y, bool lowers, double seconds) {
    constexpr double kLongest = 0.1;  // seconds: a frame that took long digs no deep pit
    if (!scene.field) return std::nullopt;
    const double rise = state.brush.strength * std::min(seconds, kLongest);
    for (const Pane& pane : panesOf(state, picture)) {
        if (x < pane.clip.x || x >= pane.clip.x + pane.clip.width) continue;
        const Vec3d way =
            pixelDirection(state.camera, x - pane.area.x, y - pane.area.y, pane.area.width, pane.area.height);
        if (const auto at = pointOnField(scene.field->heights(), cameraPosition(state.camera), way))
            return GroundStroke{toFloat(*at), float(state.brush.radius), float(lowers ? -rise : rise)};
    }
    return std::nullopt;
}

}  // namespace penumbra
