#include "player/view/view_pick.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace penumbra {

namespace {

struct Hit {
    double distance = 0, u = 0, v = 0;  // p = (1 - u - v) a + u b + v c
};

// Intersects as Moeller and Trumbore do ("Fast, minimum storage ray/triangle intersection", 1997). The determinant is
// above 0 where the front is seen.
std::optional<Hit> intersect(Vec3d origin, Vec3d direction, Vec3d a, Vec3d b, Vec3d c, bool fronts) {
    const Vec3d ab = b - a, ac = c - a, p = cross(direction, ac);
    const double determinant = dot(ab, p);
    if (determinant == 0 || (fronts && determinant < 0)) return std::nullopt;
    const Vec3d from_a = origin - a, q = cross(from_a, ab);
    const Hit hit{dot(ac, q) / determinant, dot(from_a, p) / determinant, dot(direction, q) / determinant};
    if (!(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1 && hit.distance > 0)) return std::nullopt;
    return hit;
}

}  // namespace

std::optional<std::size_t> pickVertex(std::span<const Vec3> positions, const MeshView& mesh, Vec3d origin,
                                      Vec3d direction, double& distance) {
    const std::span<const std::uint32_t> triangles = mesh.triangles;
    std::optional<std::size_t> nearest;
    distance = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
        const auto corner = [&](std::size_t i) { return toDouble(positions[triangles[t + i]]); };
        const std::optional<Hit> hit = intersect(origin, direction, corner(0), corner(1), corner(2), mesh.cull_backs);
        if (!hit || hit->distance >= distance) continue;
        distance = hit->distance;
        const double w = 1 - hit->u - hit->v;
        nearest = triangles[t + (w >= hit->u && w >= hit->v ? 0u : hit->u >= hit->v ? 1u : 2u)];
    }
    return nearest;
}

namespace {

// Returns the direction in which the camera sees (x, y), nothing beside all panes.
std::optional<Vec3d> directionAt(const ViewState& state, const Rectangle& picture, double x, double y) {
    for (const Pane& pane : panesOf(state, picture))
        if (x >= pane.clip.x && x < pane.clip.x + pane.clip.width)
            return pixelDirection(state.camera, x - pane.area.x, y - pane.area.y, pane.area.width, pane.area.height);
    return std::nullopt;
}

}  // namespace

std::optional<PickedVertex> pick(const Scene& scene, const ViewState& state, const Rectangle& picture, double x,
                                 double y) {
    const std::optional<Vec3d> direction = directionAt(state, picture, x, y);
    if (!direction || y < picture.y || y >= picture.y + picture.height) return std::nullopt;
    std::optional<PickedVertex> nearest;
    double nearest_distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const CharacterPose& posed = scene.characters[i]->posed;
        double distance = 0;
        const Mat3d to_model = transposed(toDouble(posed.to_scene.linear()));
        const Vec3d from = cameraPosition(state.camera) - toDouble(posed.to_scene.translation());
        const auto vertex = pickVertex(posed.vertices.positions, scene.characters[i]->asset.mesh, to_model * from,
                                       to_model * *direction, distance);
        if (!vertex || distance >= nearest_distance) continue;
        nearest_distance = distance;
        nearest = PickedVertex{i, *vertex};
    }
    return nearest;
}

std::optional<Vec3d> pointAtHeight(const ViewState& state, double height, const Rectangle& picture, double x,
                                   double y) {
    constexpr double kFarthest = 20;  // times the camera's distance
    const std::optional<Vec3d> way = directionAt(state, picture, x, y);
    if (!way) return std::nullopt;
    const Vec3d eye = cameraPosition(state.camera);
    const double along = (height - eye.y) / way->y;
    if (!(along > 0 && along < kFarthest * state.camera.distance)) return std::nullopt;
    return eye + *way * along;
}

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
                                        double y, double seconds) {
    constexpr double kLongest = 0.1;  // seconds: a frame that took long digs no deep pit
    const std::optional<Vec3d> way = directionAt(state, picture, x, y);
    if (!scene.field || !way) return std::nullopt;
    const double rise = state.tool.brush.strength * std::clamp(seconds, -kLongest, kLongest);
    const auto at = pointOnField(scene.field->heights(), cameraPosition(state.camera), *way);
    if (!at) return std::nullopt;
    return GroundStroke{toFloat(*at), float(state.tool.brush.radius), float(rise)};
}

}  // namespace penumbra
