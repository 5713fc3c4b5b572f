#include "formats/common/surface_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace penumbra {

namespace {

constexpr std::uint32_t kTrianglesOfLeaf = 4;
constexpr std::size_t kMaxOpen = 64;  // more than the depth of a tree of 2^32 triangles

double squaredDistance(const BoundingBox& box, Vec3 p) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double d = std::max({double(box.low[axis]) - p[axis], double(p[axis]) - box.high[axis], 0.0});
        sum += d * d;
    }
    return sum;
}

}  // namespace

std::array<double, 3> nearestWeights(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d ab = b - a, ac = c - a;
    const double d1 = dot(ab, p - a), d2 = dot(ac, p - a);
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    const double d3 = dot(ab, p - b), d4 = dot(ac, p - b);
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        const double t = d1 - d3 > 0 ? d1 / (d1 - d3) : 0;
        return {1 - t, t, 0};
    }
    const double d5 = dot(ab, p - c), d6 = dot(ac, p - c);
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        const double t = d2 - d6 > 0 ? d2 / (d2 - d6) : 0;
        return {1 - t, 0, t};
    }
    const double va = d3 * d6 - d5 * d4, along = d4 - d3, back = d5 - d6;
    if (va <= 0 && along >= 0 && back >= 0) {
        const double t = along + back > 0 ? along / (along + back) : 0;
        return {0, 1 - t, t};
    }
    const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
    return {std::max(0.0, 1 - v - w), v, w};
}

BoundingBox SurfaceTree::boxOf(std::uint32_t triangle) const {
    const auto [a, b, c] = triangles_[triangle];
    const std::array<Vec3, 3> corners{positions_[a], positions_[b], positions_[c]};
    return boundsOf(corners);
}

SurfaceTree::SurfaceTree(std::span<const Triangle> triangles, std::span<const Vec3> positions)
    : triangles_(triangles), positions_(positions), order_(triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.reserve(triangles.size());
    if (triangles.empty()) return;
    nodes_.emplace_back();
    split(0, 0, std::uint32_t(triangles.size()));
}

void SurfaceTree::split(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
    const auto centerOf = [&](std::uint32_t t, int axis) {
        const BoundingBox box = boxOf(t);
        return box.low[axis] + box.high[axis];
    };
    BoundingBox box = boxOf(order_[begin]);
    for (std::uint32_t i = begin + 1; i < end; ++i) box = merged(box, boxOf(order_[i]));
    nodes_[node] = {box, begin, end};
    if (end - begin <= kTrianglesOfLeaf) return;
    const Vec3 size = box.high - box.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) {
                         const float x = centerOf(a, axis), y = centerOf(b, axis);
                         return x != y ? x < y : a < b;
                     });
    const auto child = std::uint32_t(nodes_.size());
    nodes_[node].begin = child;
    nodes_[node].end = 0;
    nodes_.resize(nodes_.size() + 2);
    split(child, begin, middle);
    split(child + 1, middle, end);
}

std::optional<TreePoint> SurfaceTree::nearest(Vec3 point, const Cost& cost) const {
    std::optional<TreePoint> best;
    double least = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, std::uint32_t>> open;  // squared distance, node
    if (!nodes_.empty()) open.emplace_back(squaredDistance(nodes_[0].box, point), 0u);
    const Vec3d p = toDouble(point);
    while (!open.empty()) {
        const auto [away, index] = open.back();
        open.pop_back();
        if (away > least) continue;
        const Node& node = nodes_[index];
        if (node.end == 0) {
            std::pair<double, std::uint32_t> near{squaredDistance(nodes_[node.begin].box, point), node.begin};
            std::pair<double, std::uint32_t> far{squaredDistance(nodes_[node.begin + 1].box, point), node.begin + 1};
            if (far < near) std::swap(near, far);
            open.push_back(far);
            open.push_back(near);
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            const std::uint32_t t = order_[i];
            const Vec3d a = toDouble(positions_[triangles_[t][0]]), b = toDouble(positions_[triangles_[t][1]]),
                        c = toDouble(positions_[triangles_[t][2]]);
            const std::array<double, 3> w = nearestWeights(p, a, b, c);
            const Vec3d way = a * w[0] + b * w[1] + c * w[2] - p;
            const double squared = dot(way, way);
            if (squared > least) continue;
            const double sum = squared + cost(t, w);
            if (!(sum < least) && !(sum == least && best && t < best->triangle)) continue;
            least = sum;
            best = TreePoint{t, w, length(way)};
        }
    }
    return best;
}

namespace {

// A ray, ready for boxes. Division by a coordinate 0 gives infinities, which the comparisons below allow for.
struct Ray {
    Vec3 origin, direction, inverse;
};

bool meets(const BoundingBox& box, const Ray& ray) {
    float begin = 0, end = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const float a = (box.low[axis] - ray.origin[axis]) * ray.inverse[axis],
                    b = (box.high[axis] - ray.origin[axis]) * ray.inverse[axis];
        begin = std::max(begin, std::min(a, b));  // a NaN, of a ray within a face, changes nothing
        end = std::min(end, std::max(a, b));
    }
    return begin <= end * (1 + 4 * std::numeric_limits<float>::epsilon());
}

// Moeller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection". Returns u and v where the ray meets the
// triangle.
std::optional<std::array<float, 2>> meeting(const Ray& ray, Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 ab = b - a, ac = c - a, p = cross(ray.direction, ac);
    const float determinant = dot(ab, p);
    if (determinant == 0) return {};
    const Vec3 from = ray.origin - a, q = cross(from, ab);
    const float u = dot(from, p) / determinant, v = dot(ray.direction, q) / determinant;
    if (!(u >= 0 && v >= 0 && u + v <= 1 && dot(ac, q) / determinant > 0)) return {};
    return std::array<float, 2>{u, v};
}

}  // namespace

double SurfaceTree::passing(Vec3 origin, Vec3 direction, const Opacity& opacity) const {
    const Ray ray{origin, direction, {1 / direction.x, 1 / direction.y, 1 / direction.z}};
    std::array<std::uint32_t, kMaxOpen> open;  // nodes; a path down halves the triangles at each step
    std::size_t count = 0;
    if (!nodes_.empty()) open[count++] = 0;
    double share = 1;
    while (count > 0) {
        const Node& node = nodes_[open[--count]];
        if (!meets(node.box, ray)) continue;
        if (node.end == 0) {
            open[count++] = node.begin;
            open[count++] = node.begin + 1;
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            const std::uint32_t t = order_[i];
            const auto [a, b, c] = triangles_[t];
            const auto met = meeting(ray, positions_[a], positions_[b], positions_[c]);
            if (!met) continue;
            const std::size_t place = opacity.find(t);
            if (place == kUnlisted) return 0;
            const std::uint8_t stops =
                opacity.valuesOf(place)[opacityPiece(opacity.pieces[place], (*met)[0], (*met)[1])];
            share *= 1 - double(stops) / kStopsAll;
        }
    }
    return share;
}

}  // namespace penumbra
