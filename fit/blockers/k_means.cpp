#include "fit/blockers/k_means.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <random>

namespace penumbra {

namespace {

constexpr int kMaxRounds = 100;

double squaredDistance(Vec3d a, Vec3d b) { return dot(a - b, a - b); }

// Returns true when a point has changed its group.
bool assignPoints(std::span<const Vec3d> points, PointGroups& groups) {
    bool changed = false;
    groups.squares = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        double least = std::numeric_limits<double>::infinity();
        std::uint32_t nearest = 0;
        for (std::uint32_t g = 0; g < groups.centers.size(); ++g) {
            const double squared = squaredDistance(points[i], groups.centers[g]);
            if (squared < least) least = squared, nearest = g;
        }
        changed |= groups.group_of_point[i] != nearest;
        groups.group_of_point[i] = nearest;
        groups.squares += least;
    }
    return changed;
}

void moveCenters(std::span<const Vec3d> points, PointGroups& groups) {
    std::vector<Vec3d> sums(groups.centers.size());
    std::vector<std::size_t> counts(groups.centers.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        sums[groups.group_of_point[i]] += points[i];
        ++counts[groups.group_of_point[i]];
    }
    for (std::size_t g = 0; g < counts.size(); ++g)
        if (counts[g] > 0) groups.centers[g] = sums[g] / double(counts[g]);
}

void dropEmptyGroups(PointGroups& groups) {
    std::vector<std::uint32_t> new_of_old(groups.centers.size(), UINT32_MAX);
    for (const std::uint32_t g : groups.group_of_point) new_of_old[g] = 0;
    std::vector<Vec3d> centers;
    for (std::size_t g = 0; g < new_of_old.size(); ++g) {
        if (new_of_old[g] == UINT32_MAX) continue;
        new_of_old[g] = std::uint32_t(centers.size());
        centers.push_back(groups.centers[g]);
    }
    groups.centers = std::move(centers);
    for (std::uint32_t& g : groups.group_of_point) g = new_of_old[g];
}

double uniformNumber(std::mt19937_64& random) { return double(random() >> 11) * 0x1p-53; }

// Takes each next point with a chance that grows with the square of its distance from the nearest one before.
std::vector<Vec3d> farPoints(std::span<const Vec3d> points, int count, std::mt19937_64& random) {
    std::vector<Vec3d> chosen{points[std::size_t(uniformNumber(random) * double(points.size()))]};
    std::vector<double> squared(points.size(), std::numeric_limits<double>::infinity());
    while (int(chosen.size()) < count) {
        double sum = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            squared[i] = std::min(squared[i], squaredDistance(points[i], chosen.back()));
            sum += squared[i];
        }
        if (!(sum > 0)) break;  // all places are taken
        double left = uniformNumber(random) * sum;
        std::size_t next = 0;
        while (next + 1 < points.size() && left >= squared[next]) left -= squared[next++];
        chosen.push_back(points[next]);
    }
    return chosen;
}

}  // namespace

PointGroups improveGroups(std::span<const Vec3d> points, std::vector<Vec3d> centers) {
    assert(!points.empty() && !centers.empty());
    PointGroups groups{std::move(centers), std::vector<std::uint32_t>(points.size(), UINT32_MAX)};
    for (int round = 0; round < kMaxRounds && assignPoints(points, groups); ++round) moveCenters(points, groups);
    dropEmptyGroups(groups);
    return groups;
}

PointGroups groupPoints(std::span<const Vec3d> points, int count, std::uint64_t seed) {
    assert(count > 0);
    std::mt19937_64 random(seed);
    PointGroups best;
    for (int start = 0; start < kGroupStarts; ++start) {
        PointGroups groups = improveGroups(points, farPoints(points, count, random));
        if (start == 0 || groups.squares < best.squares) best = std::move(groups);
    }
    return best;
}

}  // namespace penumbra
