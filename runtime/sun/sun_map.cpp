// The share of a sun that a point sees.
//
// Problem: the disc of the sun, projected through a blocker at distance D, has the radius R = D tan a. Filtering the
// comparisons of depths over a box of 1.71 R gives the penumbra of a straight edge within .032, but D is not known.
//
// Naive: look for blockers in a box that fits the farthest caster, and filter with their mean distance
// (percentage-closer soft shadows, Fernando 2005). Where a foot stands on the ground, the box sees the whole body, the
// mean distance is too large and light leaks in.
//
// Here: the box shrinks to the distance that it finds, and looks again. The last box is the filter. A wide box looks at
// few of its texels: it is cut into cells whose grid is fixed to the map, and each cell tests one texel. The share of
// the box that a cell covers is its weight, so that results change continuously with the point and show no bands. The
// tested texel's place within its cell differs from row to row and from column to column, so that edges along the grid
// do not fall on all cells at once.
#include "runtime/sun/sun_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

constexpr float kSunWidest = 1 << 20;  // texels, of a box: cells have numbers that are ints
constexpr int kSubTexels = 256;        // corners of triangles lie at multiples of 1/256 texel, as on GPUs

struct GridPoint {
    std::int64_t x, y;
};

// Twice the area of (a, b, p), positive when p lies to the left.
std::int64_t edgeSide(GridPoint a, GridPoint b, GridPoint p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// Points on an edge belong to one of its two triangles (top-left rule).
std::int64_t edgeBias(GridPoint a, GridPoint b) { return b.y < a.y || (b.y == a.y && b.x < a.x) ? 0 : -1; }

struct MapRows {
    std::span<float> depths;
    int size, first, last;
    float range;
};

int firstCenter(std::int64_t low) { return int((low + kSubTexels / 2 - 1) >> 8); }
int lastCenter(std::int64_t high) { return int((high - kSubTexels / 2) >> 8); }

// Draws a triangle of places (column, row, depth). Depths are linear over it, at the centers of texels.
void drawTriangle(const MapRows& map, std::array<Vec3, 3> corner) {
    std::array<GridPoint, 3> p;
    for (std::size_t i = 0; i < 3; ++i)
        p[i] = {std::llround(corner[i].x * kSubTexels), std::llround(corner[i].y * kSubTexels)};
    const std::int64_t area = edgeSide(p[0], p[1], p[2]);
    if (area == 0) return;
    if (area < 0) {  // both sides cast
        std::swap(p[1], p[2]);
        std::swap(corner[1], corner[2]);
    }
    const auto [low_x, high_x] = std::minmax({p[0].x, p[1].x, p[2].x});
    const auto [low_y, high_y] = std::minmax({p[0].y, p[1].y, p[2].y});
    const int x0 = std::max(firstCenter(low_x), 0), x1 = std::min(lastCenter(high_x), map.size - 1);
    const int y0 = std::max(firstCenter(low_y), map.first), y1 = std::min(lastCenter(high_y), map.last - 1);

    const float scale = 1 / (float(std::abs(area)) * map.range);
    for (int y = y0; y <= y1; ++y) {
        const GridPoint center{std::int64_t(x0) * kSubTexels + kSubTexels / 2,
                               std::int64_t(y) * kSubTexels + kSubTexels / 2};
        std::array<std::int64_t, 3> side, step, bias;
        for (std::size_t i = 0; i < 3; ++i) {
            const GridPoint a = p[(i + 1) % 3], b = p[(i + 2) % 3];
            side[i] = edgeSide(a, b, center);
            step[i] = -(b.y - a.y) * kSubTexels;
            bias[i] = edgeBias(a, b);
        }
        float* row = map.depths.data() + std::size_t(y) * std::size_t(map.size);
        for (int x = x0; x <= x1; ++x) {
            if (side[0] + bias[0] >= 0 && side[1] + bias[1] >= 0 && side[2] + bias[2] >= 0) {
                const float depth = scale * (float(side[0]) * corner[0].z + float(side[1]) * corner[1].z +
                                             float(side[2]) * corner[2].z);
                row[x] = std::min(row[x], depth);
            }
            for (std::size_t i = 0; i < 3; ++i) side[i] += step[i];
        }
    }
}

bool isFinitePlace(Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// A point of a surface, and the depths of its plane over the map.
struct SunReceiver {
    Vec3 place;              // less the bias in depth
    float slope_x, slope_y;  // slopes of the depth
};

struct BoxBlockers {
    float share = 0;     // share of the box that blockers cover
    float distance = 0;  // mean, in texels; only with share > 0
};

// Where cell `across` of a line tests its texel, from its start: the multiples of the golden section.
int cellTexel(int across, int stride) { return (((across * 40503) & 65535) * stride) >> 16; }

// The length that the box shares with cell i, for a box from `low` to `high` along one axis.
float overlap(int i, int stride, float low, float high) {
    return std::min(high, float((i + 1) * stride)) - std::max(low, float(i * stride));
}

enum class SunPass { kSearch, kFilter };

// How much of a texel counts in a search that blocks at the distance `ahead`, `away` from the receiver along the longer
// axis. Only what stands before the sun's disc hides any of it: the slopes of a valley rise above the plane of its
// floor and hide nothing. The slack of two cells keeps the count continuous.
float beforeSun(const SunFrame& frame, float ahead, float away, int stride) {
    const float reach = kSunBox / 2 * frame.tan_radius * ahead;
    return std::clamp((reach - away) / float(stride) + 2, 0.0f, 1.0f);
}

BoxBlockers lookThroughBox(const SunFrame& frame, std::span<const float> depths, const SunReceiver& receiver,
                           float side, SunPass pass) {
    const int cells = pass == SunPass::kSearch ? kSunSearchCells : kSunCells;
    const int stride = std::max(1, int(std::ceil(side / float(cells))));
    const float x_low = receiver.place.x - side / 2, x_high = receiver.place.x + side / 2;
    const float y_low = receiver.place.y - side / 2, y_high = receiver.place.y + side / 2;
    const auto cellOf = [&](float at) { return int(std::floor(at / float(stride))); };
    float total = 0, blocked = 0, distance = 0;
    for (int j = cellOf(y_low); j <= cellOf(y_high); ++j)
        for (int i = cellOf(x_low); i <= cellOf(x_high); ++i) {
            const int x = i * stride + cellTexel(j, stride), y = j * stride + cellTexel(i, stride);
            const float weight = overlap(i, stride, x_low, x_high) * overlap(j, stride, y_low, y_high);
            total += weight;
            if (x < 0 || y < 0 || x >= frame.size || y >= frame.size) continue;
            const float stored = depths[std::size_t(y) * std::size_t(frame.size) + std::size_t(x)];
            const float away_x = float(x) + 0.5f - receiver.place.x, away_y = float(y) + 0.5f - receiver.place.y;
            const float ahead = receiver.place.z - stored * frame.range;
            const float above = ahead + receiver.slope_x * away_x + receiver.slope_y * away_y;
            if (stored >= 1 || above <= 0) continue;
            const float away = std::max(std::abs(away_x), std::abs(away_y));
            const float counted = weight * (pass == SunPass::kSearch ? beforeSun(frame, ahead, away, stride) : 1);
            blocked += counted;
            distance += counted * above;
        }
    if (!(blocked > 0)) return {};
    return {blocked / total, distance / blocked};
}

}  // namespace

void SunMap::begin(const SunFrame& frame) {
    frame_ = frame;
    depths_.assign(std::size_t(frame.size) * std::size_t(frame.size), 1.0f);
}

void SunMap::draw(std::span<const SunCaster> casters, int first, int last) {
    if (frame_.size == 0) return;
    assert(first >= 0 && last <= frame_.size);
    const MapRows map{depths_, frame_.size, first, last, frame_.range};
    for (const SunCaster& caster : casters)
        for (std::size_t t = 0; t + 2 < caster.triangles.size(); t += 3) {
            std::array<Vec3, 3> corner;
            for (std::size_t i = 0; i < 3; ++i) corner[i] = frame_.place(caster.positions[caster.triangles[t + i]]);
            if (isFinitePlace(corner[0]) && isFinitePlace(corner[1]) && isFinitePlace(corner[2]))
                drawTriangle(map, corner);
        }
}

float SunMap::visibility(Vec3 position, Vec3 normal) const {
    if (frame_.size == 0) return 1;
    const Vec3 at = frame_.place(position), n = frame_.turned(normal);
    const float cosine = -n.z;
    if (!(cosine > 0) || !isFinitePlace(at)) return 0;
    const float limited = std::max(cosine, kSunMinCosine);
    const float tangent = std::sqrt(std::max(1 - limited * limited, 0.0f)) / limited;
    const SunReceiver receiver{{at.x, at.y, at.z - kSunBias - kSunSlopeBias * tangent}, n.x / limited, n.y / limited};
    // No blocker is farther away than the first caster, at depth 0.
    const float widest = std::clamp(2 * at.z * frame_.tan_radius, 1.0f, kSunWidest);
    const float edge = float(frame_.size) + widest;
    if (!(std::max(std::abs(at.x), std::abs(at.y)) < edge)) return 1;  // beyond all casters
    float side = widest;
    BoxBlockers blockers;
    for (int pass = 0; pass < kSunPasses; ++pass) {
        blockers = lookThroughBox(frame_, depths_, receiver, side,
                                  pass + 1 < kSunPasses ? SunPass::kSearch : SunPass::kFilter);
        const float next = std::clamp(kSunBox * blockers.distance * frame_.tan_radius, 1.0f, widest);
        if (blockers.share == 0 || blockers.share == 1 || std::max(side, next) == 1) break;
        if (pass + 1 < kSunPasses) side = next;
    }
    return 1 - blockers.share;
}

void SunMaps::begin(const SunCasters& casters, Vec3 direction, float radius, int size) {
    fitSunNest(casters, direction, radius, size, nest_);
    maps_.resize(nest_.maps.size());
    for (std::size_t i = 0; i < maps_.size(); ++i) maps_[i].begin(nest_.maps[i].frame);
}

void SunMaps::draw(const SunCasters& casters, int band, int bands) {
    for (std::size_t i = 0; i < maps_.size(); ++i) {
        const NestedSunMap& nested = nest_.maps[i];
        const int rows = nested.frame.size, first = rows * band / bands, last = rows * (band + 1) / bands;
        for (const std::uint32_t m : nested.members) maps_[i].draw({&casters.members[m], 1}, first, last);
        SunCaster ground = casters.ground;
        if (!nested.whole_ground) ground.triangles = nested.ground;
        maps_[i].draw({&ground, 1}, first, last);
    }
}

float SunMaps::visibility(Vec3 position, Vec3 normal) const {
    if (maps_.empty()) return 1;
    float sum = 0, before = 0, left = 1;  // sums of differences are exact where maps agree
    for (std::size_t i = 0; i < maps_.size() && left > 0; ++i) {
        const float weight = nest_.maps[i].weight(position);
        if (weight == 0) continue;
        const float share = maps_[i].visibility(position, normal);
        sum += left * (share - before);
        before = share;
        left *= 1 - weight;
    }
    return sum;
}

}  // namespace penumbra
