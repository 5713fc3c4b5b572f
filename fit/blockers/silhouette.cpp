// Finds areas of silhouettes.
//
// Problem: the silhouettes of spheres, and those of triangles, overlap, and the overlaps must count once.
//
// Naive: a picture of the silhouette, whose covered pixels are counted. Small triangles slip between pixels, and the
// area is a step function of a radius, which a search for the right radius does not like.
//
// Here: parallel lines instead of pixels. A line cuts each shape in an interval, whose ends are exact. The length of
// the union of all intervals, times the distance of the lines, adds up to the area. It grows steadily with a radius.
#include "fit/blockers/silhouette.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "sh/quadrature.h"

namespace penumbra {

namespace {

struct Interval {
    double begin, end;
};

// The lines, at low + (row + 1/2) step, and the intervals that were cut from each.
struct ScanLines {
    double low = 0, step = 0;
    std::vector<std::vector<Interval>> intervals;

    ScanLines(double bottom, double top)
        : low(bottom), step((top - bottom) / kSilhouetteRows), intervals(std::size_t(kSilhouetteRows)) {}
    // Returns the first row that is not below `height`, between 0 and the number of rows.
    std::size_t rowFrom(double height) const {
        return std::size_t(std::clamp(std::ceil((height - low) / step - 0.5), 0.0, double(kSilhouetteRows)));
    }
    double heightOf(std::size_t row) const { return low + (double(row) + 0.5) * step; }
};

double coveredLength(std::vector<Interval>& intervals) {
    std::sort(intervals.begin(), intervals.end(), [](const Interval& a, const Interval& b) {
        return a.begin != b.begin ? a.begin < b.begin : a.end < b.end;
    });
    double covered = 0, reached = -std::numeric_limits<double>::infinity();
    for (const Interval& interval : intervals) {
        covered += std::max(0.0, interval.end - std::max(interval.begin, reached));
        reached = std::max(reached, interval.end);
    }
    return covered;
}

double coveredArea(ScanLines& rows) {
    double area = 0;
    for (std::vector<Interval>& intervals : rows.intervals) area += coveredLength(intervals) * rows.step;
    return area;
}

// Two unit vectors that span the plane that a view looks at.
struct Plane {
    Vec3d right, up;

    explicit Plane(Vec3d view) {
        right = normalized(cross(view, std::abs(view.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}));
        up = cross(right, view);
    }
};

struct Projected {
    double x, y;
};

void cutTriangle(const std::array<Projected, 3>& corners, ScanLines& rows) {
    const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    const std::size_t end = rows.rowFrom(high);
    for (std::size_t row = rows.rowFrom(low); row < end; ++row) {
        const double y = rows.heightOf(row);
        Interval cut{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        for (std::size_t i = 0; i < 3; ++i) {
            const Projected &a = corners[i], &b = corners[(i + 1) % 3];
            if ((a.y < y) == (b.y < y)) continue;
            const double x = a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y);
            cut = {std::min(cut.begin, x), std::max(cut.end, x)};
        }
        if (cut.begin < cut.end) rows.intervals[row].push_back(cut);
    }
}

void cutSpheres(std::span<const CasterSphere> spheres, const Plane& plane, ScanLines& rows) {
    for (const CasterSphere& sphere : spheres) {
        const double x = dot(toDouble(sphere.center), plane.right), y = dot(toDouble(sphere.center), plane.up);
        const std::size_t end = rows.rowFrom(y + sphere.radius);
        for (std::size_t row = rows.rowFrom(y - sphere.radius); row < end; ++row) {
            const double off = rows.heightOf(row) - y;
            const double half = std::sqrt(std::max(0.0, double(sphere.radius) * sphere.radius - off * off));
            rows.intervals[row].push_back({x - half, x + half});
        }
    }
}

void cutTriangles(std::span<const Triangle> triangles, std::span<const Vec3> positions, const Plane& plane,
                  ScanLines& rows) {
    std::vector<Projected> projected;
    for (const Vec3& position : positions) {
        const Vec3d p = toDouble(position);
        projected.push_back({dot(p, plane.right), dot(p, plane.up)});
    }
    for (const Triangle& t : triangles) cutTriangle({projected[t[0]], projected[t[1]], projected[t[2]]}, rows);
}

// Adds the rows to their bands.
void sumBands(ScanLines& rows, std::span<double> bands) {
    const std::size_t rows_of_band = rows.intervals.size() / bands.size();
    for (std::size_t row = 0; row < rows.intervals.size(); ++row)
        bands[row / rows_of_band] += coveredLength(rows.intervals[row]) * rows.step;
}

}  // namespace

std::vector<Vec3d> silhouetteViews(int count) {
    std::vector<Vec3d> views = fibonacciSphere(2 * count);  // from z = 1 down
    views.resize(std::size_t(count));
    return views;
}

double silhouetteArea(std::span<const CasterSphere> spheres, Vec3d view) {
    const Plane plane(view);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const CasterSphere& sphere : spheres) {
        const double y = dot(toDouble(sphere.center), plane.up);
        low = std::min(low, y - sphere.radius);
        high = std::max(high, y + sphere.radius);
    }
    if (!(low < high)) return 0;
    ScanLines rows(low, high);
    cutSpheres(spheres, plane, rows);
    return coveredArea(rows);
}

double silhouetteArea(std::span<const Triangle> triangles, std::span<const Vec3> positions, Vec3d view) {
    const SilhouetteRange range = rangeOf(positions, view);
    if (!(range.low < range.high)) return 0;
    ScanLines rows(range.low, range.high);
    cutTriangles(triangles, positions, Plane(view), rows);
    return coveredArea(rows);
}

SilhouetteRange rangeOf(std::span<const Vec3> positions, Vec3d view) {
    const Plane plane(view);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3& position : positions) {
        const double y = dot(toDouble(position), plane.up);
        low = std::min(low, y);
        high = std::max(high, y);
    }
    return {low, high};
}

void silhouetteBands(std::span<const CasterSphere> spheres, Vec3d view, SilhouetteRange range,
                     std::span<double> bands) {
    std::fill(bands.begin(), bands.end(), 0.0);
    if (!(range.low < range.high)) return;
    ScanLines rows(range.low, range.high);
    cutSpheres(spheres, Plane(view), rows);
    sumBands(rows, bands);
}

void silhouetteBands(std::span<const Triangle> triangles, std::span<const Vec3> positions, Vec3d view,
                     SilhouetteRange range, std::span<double> bands) {
    std::fill(bands.begin(), bands.end(), 0.0);
    if (!(range.low < range.high)) return;
    ScanLines rows(range.low, range.high);
    cutTriangles(triangles, positions, Plane(view), rows);
    sumBands(rows, bands);
}

}  // namespace penumbra
