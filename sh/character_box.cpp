// Finds the box of a character beside things that are not.
//
// Problem: lengths of a bake (where rays start, which vertices are one) are shares of the character's size. A file may
// also have a floor of a kilometre, and a share of that is more than the gap between two legs.
//
// Naive: take the box of everything, or leave out what is not skinned. A robot has no skin, and a weapon's trail has.
//
// Here: a character is where most of the triangles are, weighted so that a fine grid of a floor does not outvote it. A
// triangle counts as far only well beyond everything that characters have: of 17 rigs none reaches farther than 4
// times the median. docs/inputs.md tells users what is left out.
#include "sh/character_box.h"

#include <cassert>
#include <cmath>
#include <vector>

namespace penumbra {

namespace {

struct Weighted {
    double value, weight;
};

double weightedMedian(std::vector<Weighted>& values) {
    std::sort(values.begin(), values.end(), [](Weighted a, Weighted b) { return a.value < b.value; });
    double total = 0, sum = 0;
    for (const Weighted& v : values) total += v.weight;
    for (const Weighted& v : values)
        if ((sum += v.weight) >= 0.5 * total) return v.value;
    return values.empty() ? 0 : values.back().value;
}

struct TriangleCorners {
    std::span<const std::uint32_t> indices;
    std::span<const Vec3> points;

    std::size_t count() const { return indices.size() / 3; }
    Vec3d at(std::size_t triangle, std::size_t k) const { return toDouble(points[indices[3 * triangle + k]]); }
};

double longestEdge(const TriangleCorners& corners, std::size_t t) {
    const Vec3d a = corners.at(t, 0), b = corners.at(t, 1), c = corners.at(t, 2);
    return std::max({length(b - a), length(c - b), length(a - c)});
}

std::vector<double> weightsOf(const TriangleCorners& corners) {
    std::vector<double> weights;
    double inverse = 0;
    std::size_t count = 0;
    for (std::size_t t = 0; t < corners.count(); ++t) {
        weights.push_back(longestEdge(corners, t));
        if (weights.back() > 0) inverse += 1 / weights.back(), ++count;
    }
    const double mean = inverse > 0 ? double(count) / inverse : 0;
    for (double& w : weights)  // leaves weights that are not finite as they are
        if (std::isfinite(w)) w = w > mean ? mean / w : w > 0 ? 1 : 0;
    return weights;
}

// Medians look at this many triangles, evenly through the list, or at all where there are fewer.
constexpr std::size_t kSampled = 100000;

Vec3d medianCorner(const TriangleCorners& corners, const std::vector<double>& weights) {
    const std::size_t step = 1 + corners.count() / kSampled;
    Vec3d middle;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<Weighted> values;
        for (std::size_t t = 0; t < corners.count(); t += step)
            values.push_back({corners.at(t, t % 3)[axis], weights[t]});
        middle[axis] = weightedMedian(values);
    }
    return middle;
}

BoundingBox boxOfCorners(std::span<const std::uint32_t> corners, std::span<const Vec3> points) {
    BoundingBox box{points[corners.front()], points[corners.front()]};
    for (const std::uint32_t corner : corners) box = merged(box, {points[corner], points[corner]});
    return box;
}

// Returns how far each triangle reaches from `middle`.
std::vector<double> reachesOf(const TriangleCorners& corners, Vec3d middle) {
    std::vector<double> reaches;
    for (std::size_t t = 0; t < corners.count(); ++t) {
        double reach = 0;
        for (std::size_t k = 0; k < 3; ++k) reach = std::max(reach, length(corners.at(t, k) - middle));
        reaches.push_back(reach);
    }
    return reaches;
}

}  // namespace

BoundingBox characterBox(std::span<const std::uint32_t> indices, std::span<const Vec3> points) {
    if (indices.empty()) return boundsOf(points);
    assert(indices.size() % 3 == 0);
    const TriangleCorners corners{indices, points};
    const std::vector<double> weights = weightsOf(corners);
    const auto is_finite = [](double weight) { return std::isfinite(weight); };
    if (!std::all_of(weights.begin(), weights.end(), is_finite)) return boxOfCorners(indices, points);
    const std::vector<double> reaches = reachesOf(corners, medianCorner(corners, weights));
    std::vector<Weighted> sampled;
    for (std::size_t t = 0; t < reaches.size(); t += 1 + reaches.size() / kSampled)
        sampled.push_back({reaches[t], weights[t]});
    const double median = weightedMedian(sampled), farthest = *std::max_element(reaches.begin(), reaches.end());
    if (!(farthest > kFarReach * median) || !(median > 0)) return boxOfCorners(indices, points);
    std::vector<std::uint32_t> kept;
    for (std::size_t t = 0; t < reaches.size(); ++t)
        if (reaches[t] <= kKeptReach * median)
            kept.insert(kept.end(), {indices[3 * t], indices[3 * t + 1], indices[3 * t + 2]});
    return boxOfCorners(kept, points);
}

}  // namespace penumbra
