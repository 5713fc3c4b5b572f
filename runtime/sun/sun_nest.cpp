// Problem: a ground of 500 m in a map of 1024 texels has texels of 0.7 m, in which a man has no shadow.
//
// Naive: a map of more texels. A man needs 200 times as many a side.
//
// Here: nested maps (cascades), as for cameras, but around who casts. Along the rays of a sun a caster and its shadow
// have the same place in the map. So the map that fits a character holds its shadow, too, wherever it falls, and needs
// room for the penumbra alone. Characters far from one another are groups with a map each. Around them lie rings, maps
// of 8 times the side of the one before, so that the shadows that a ground casts on itself get coarser step by step as
// they do for cameras. The last map is the one over everything. Biases and widths of penumbras are counted in texels of
// the map that is looked up, so no map needs to know of another. Who is too small for a coarse map has no place in it,
// because its shadow would lie there in texels as large as itself, and stick out of the finer map.
#include "runtime/sun/sun_nest.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "runtime/sun/cut_triangle.h"
#include "runtime/sun/sun_map.h"

namespace penumbra {

namespace {

constexpr double kFineEnough = 128;           // texels across the least member
constexpr double kRingFactor = 8;             // sides of a ring and the one before
constexpr double kCoarsestShadow = 16;        // texels of a map that members cast in, in those of the finest
constexpr double kGroupShare = 0.75;          // share of a group's map that its members fill
constexpr double kLargestTriangle = 1 << 20;  // texels; on larger ones floats tell places no better than the bias
constexpr double kMaxUneven = 16;             // sides of the largest group and the smallest that share out the maps
constexpr int kBorderShare = 16;              // share of a map's side that is its border, and by which it moves

double sideOf(const SunBounds& box) { return std::max(box.high.x - box.low.x, box.high.y - box.low.y); }

void join(SunBounds& box, const SunBounds& other) {
    if (other.empty) return;
    for (int i = 0; i < 3; ++i) {
        box.low[i] = box.empty ? other.low[i] : std::min(box.low[i], other.low[i]);
        box.high[i] = box.empty ? other.high[i] : std::max(box.high[i], other.high[i]);
    }
    box.empty = false;
}

bool overlap(const SunBounds& a, const SunBounds& b) {
    for (int i = 0; i < 2; ++i)
        if (!(a.low[i] <= b.high[i] && b.low[i] <= a.high[i])) return false;
    return true;
}

struct Group {
    std::vector<std::uint32_t> members;
    SunBounds box;
};

// Cuts a group in two where the larger half is smallest, along its longer side.
std::array<Group, 2> halves(const Group& group, std::span<const SunBounds> boxes) {
    const Vec3d extent = group.box.high - group.box.low;
    const int axis = extent.x >= extent.y ? 0 : 1;
    std::vector<std::uint32_t> order = group.members;
    std::ranges::stable_sort(order, {}, [&](std::uint32_t m) { return boxes[m].low[axis] + boxes[m].high[axis]; });
    std::vector<SunBounds> before(order.size()), after(order.size());  // bounds of the members up to each one, and from
                                                                       // each one on
    for (std::size_t i = 0; i < order.size(); ++i) {
        const std::size_t j = order.size() - 1 - i;
        if (i > 0) before[i] = before[i - 1], after[j] = after[j + 1];
        join(before[i], boxes[order[i]]);
        join(after[j], boxes[order[j]]);
    }
    std::size_t best = 1;
    const auto larger = [&](std::size_t cut) { return std::max(sideOf(before[cut - 1]), sideOf(after[cut])); };
    for (std::size_t cut = 2; cut < order.size(); ++cut)
        if (larger(cut) < larger(best)) best = cut;
    const auto middle = order.begin() + std::ptrdiff_t(best);
    return {{{{order.begin(), middle}, before[best - 1]}, {{middle, order.end()}, after[best]}}};
}

double smallestSide(const std::vector<Group>& groups) {
    double side = HUGE_VAL;
    for (const Group& group : groups) side = std::min(side, sideOf(group.box));
    return side;
}

double largestSide(const std::vector<Group>& groups) {
    double side = 0;
    for (const Group& group : groups) side = std::max(side, sideOf(group.box));
    return side;
}

// Cuts the largest group, again and again. More groups are taken where the largest one is at most half as wide then.
std::vector<Group> groupsOf(std::span<const SunBounds> boxes) {
    std::vector<Group> groups(1);
    for (std::size_t m = 0; m < boxes.size(); ++m) {
        if (boxes[m].empty) continue;
        groups[0].members.push_back(std::uint32_t(m));
        join(groups[0].box, boxes[m]);
    }
    std::vector<Group> taken = groups;
    while (groups.size() < kMaxSunGroups) {
        const auto largest = std::ranges::max_element(groups, {}, [](const Group& g) { return sideOf(g.box); });
        if (largest->members.size() < 2) break;
        std::array<Group, 2> cut = halves(*largest, boxes);
        *largest = std::move(cut[0]);
        groups.push_back(std::move(cut[1]));
        if (largestSide(groups) <= largestSide(taken) / 2) taken = groups;
    }
    // Where there are more crowds than maps, those that are small keep theirs.
    return largestSide(groups) > kMaxUneven * smallestSide(groups) ? groups : taken;
}

// Fits maps of one sun.
class NestFit {
public:
    NestFit(const SunCasters& casters, const Mat3d& axes, float radius, int size)
        : casters_(casters), axes_(axes), radius_(radius), size_(size) {}

    void fit(SunNest& nest) {
        measure();
        nest.maps.resize(all_.empty ? 0 : 1);
        if (all_.empty) return;
        const double whole = fittingTexel(all_, size_);
        if (isFineEnough(whole)) return fitWhole(whole, nest.maps[0]);
        std::vector<Group> groups = groupsOf(boxes_);
        const auto texelOf = [&](const Group& group) {
            return texelStep(sideOf(group.box) / (kGroupShare * size_), group.box);
        };
        // Members without a fine map cast in the coarse ones.
        std::erase_if(groups, [&](const Group& group) {
            if (texelOf(group) <= whole / 2) return false;
            coarse_.insert(coarse_.end(), group.members.begin(), group.members.end());
            return true;
        });
        if (groups.empty()) return fitWhole(whole, nest.maps[0]);

        double finest = HUGE_VAL, widest = 0;
        turnGround();
        nest.maps.clear();
        for (const Group& group : groups) {
            finest = std::min(finest, texelOf(group));
            widest = std::max(widest, texelOf(group));
            fitInner(group.box, texelOf(group), 1, nest.maps.emplace_back());
        }
        double texel = std::max(sideOf(members_) / (kGroupShare * size_), kRingFactor * widest);
        for (int ring = 0; ring < kMaxSunRings && 4 * texel <= whole; ++ring, texel *= kRingFactor) {
            const double step = texelStep(texel, members_);
            fitInner(members_, step, size_ / kBorderShare, nest.maps.emplace_back());
            if (step > kCoarsestShadow * finest) keepCoarse(nest.maps.back());
        }
        std::erase_if(nest.maps, [&](const NestedSunMap& map) { return double(map.frame.texel) > whole / 2; });
        fitWhole(whole, nest.maps.emplace_back());
        if (nest.maps.size() > 1 && whole > kCoarsestShadow * finest) keepCoarse(nest.maps.back());
    }

private:
    const SunCasters& casters_;
    Mat3d axes_;
    float radius_;
    int size_;
    SunBounds members_, all_;            // along the axes
    std::vector<SunBounds> boxes_;       // one for each member; none without a ground
    std::vector<std::uint32_t> coarse_;  // members without a fine map
    std::vector<Vec3d> ground_;          // the points of the ground, along the axes
    std::vector<std::uint8_t> sides_;    // for each point of the ground, the sides of a window beyond which it lies, as
                                         // bits

    void measure() {
        const bool may_nest = !casters_.ground.triangles.empty();
        for (const SunCaster& caster : casters_.members) {
            SunBounds box;
            includeInBounds(axes_, caster.positions, box);
            join(members_, box);
            if (may_nest) boxes_.push_back(box);
        }
        all_ = members_;
        includeInBounds(axes_, casters_.ground.positions, all_);
    }

    bool isFineEnough(double texel) const {
        if (casters_.ground.triangles.empty() || members_.empty) return true;
        double least = HUGE_VAL;
        for (const SunCaster& caster : casters_.members) {
            SunBounds box;
            includeInBounds(Mat3d{}, caster.positions, box);
            const Vec3d extent = box.high - box.low;
            if (!box.empty) least = std::min(least, std::max({extent.x, extent.y, extent.z}));
        }
        return texel * kFineEnough <= least;
    }

    // Leaves those members that have no finer map.
    void keepCoarse(NestedSunMap& map) const {
        std::erase_if(map.members, [&](std::uint32_t m) { return std::ranges::find(coarse_, m) == coarse_.end(); });
    }

    void fitWhole(double texel, NestedSunMap& map) const {
        map.frame = layFrame(axes_, all_, texel, radius_, size_);
        map.border = 0;
        map.members.resize(casters_.members.size());
        std::iota(map.members.begin(), map.members.end(), 0u);
        map.whole_ground = true;
        map.ground.clear();
    }

    void turnGround() {
        for (const Vec3 point : casters_.ground.positions) ground_.push_back(axes_ * toDouble(point));
        sides_.resize(ground_.size());
    }

    // Fits a map around the middle of a box. Its corner lies at a multiple of `step` texels.
    void fitInner(const SunBounds& box, double texel, int step, NestedSunMap& map) {
        const Vec3d middle = (box.low + box.high) * 0.5;
        SunBounds window = box;
        for (int i = 0; i < 2; ++i) {
            const double corner = step * std::round((middle[i] / texel - 0.5 * size_) / step);
            window.low[i] = corner * texel;
            window.high[i] = (corner + size_) * texel;
        }
        window.empty = true;  // its depths are still unknown
        SunBounds depths;
        for (std::uint32_t m = 0; m < boxes_.size(); ++m) {
            if (boxes_[m].empty || !overlap(boxes_[m], window)) continue;
            map.members.push_back(m);
            join(depths, boxes_[m]);
        }
        map.whole_ground = false;
        const double largest = takeGround(window, depths, map.ground);
        if (largest > kLargestTriangle * texel) {
            map.members.clear();
            map.ground.clear();
            return fitInner(box, texelStep(largest / kLargestTriangle, box), step, map);
        }
        for (int i = 0; i < 2; ++i) window.low[i] += 1.5 * texel;  // layFrame() begins a texel before
        window.low.z = depths.low.z;
        window.high.z = depths.high.z;
        map.frame = layFrame(axes_, window, texel, radius_, size_, toFloat(transposed(axes_) * middle));
        map.border = float(size_) / kBorderShare;
    }

    // Takes the triangles that reach into the window, and includes their depths. Returns the longest side of those that
    // reach out of it.
    double takeGround(const SunBounds& window, SunBounds& depths, std::vector<std::uint32_t>& triangles) {
        constexpr unsigned kNowhere = 16;
        for (std::size_t p = 0; p < ground_.size(); ++p) {
            const Vec3d at = ground_[p];
            sides_[p] = std::uint8_t((at.x < window.low.x) | (at.x > window.high.x) << 1 | (at.y < window.low.y) << 2 |
                                     (at.y > window.high.y) << 3);
            if (!std::isfinite(at.x + at.y + at.z)) sides_[p] = kNowhere;
        }
        const std::span<const std::uint32_t> all = casters_.ground.triangles;
        CutTriangle polygon;
        double largest = 0;
        for (std::size_t t = 0; t + 2 < all.size(); t += 3) {
            const unsigned a = sides_[all[t]], b = sides_[all[t + 1]], c = sides_[all[t + 2]];
            if (a & b & c || (a | b | c) & kNowhere) continue;
            // Only depths inside the window count for a large triangle.
            const std::size_t corners = cutTriangle({ground_[all[t]], ground_[all[t + 1]], ground_[all[t + 2]]},
                                                    window.low, window.high, polygon);
            for (std::size_t i = 0; i < corners; ++i) {
                depths.low.z = std::min(depths.low.z, polygon[i].z);
                depths.high.z = std::max(depths.high.z, polygon[i].z);
            }
            if (corners == 0) continue;
            triangles.insert(triangles.end(), &all[t], &all[t] + 3);
            if (!(a | b | c)) continue;
            for (std::size_t i = t; i < t + 3; ++i)
                largest = std::max(largest, length(ground_[all[i]] - ground_[all[i < t + 2 ? i + 1 : t]]));
        }
        return largest;
    }
};

}  // namespace

float NestedSunMap::weight(Vec3 point) const {
    if (border == 0) return 1;
    const Vec3 at = frame.place(point);
    const float widest = std::max(2 * at.z * frame.tan_radius, 1.0f);
    const float reach = widest / 2 + std::ceil(widest / float(kSunSearchCells));  // adds a cell of the search
    const float size = float(frame.size);
    const float inside = std::min({at.x, at.y, size - at.x, size - at.y}) - reach;
    if (!(inside > 0)) return 0;
    const float t = std::min(inside / border, 1.0f);
    return t * t * (3 - 2 * t);
}

void fitSunNest(const SunCasters& casters, Vec3 direction, float radius, int size, SunNest& nest) {
    assert(size >= kSmallestSunMap && size <= kLargestSunMap);
    const Vec3d toward_sun = normalized(toDouble(direction));
    nest.maps.resize(1);
    if (!std::isfinite(length(toward_sun)) || toward_sun == Vec3d{}) return nest.maps.clear();
    NestFit(casters, sunAxes(toward_sun), radius, size).fit(nest);
}

}  // namespace penumbra
