#pragma once
// A tree over the triangles of a mesh. It finds the nearest point, for tables that interpolate from its vertices, and
// tells how much of a ray passes, for checks of fields. Bakes have a faster tracer (bake/trace/occlusion.h).
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "formats/common/mesh.h"
#include "sh/bounding_box.h"

namespace penumbra {

// A point of a surface: barycentric weights of the corners of a triangle.
struct TreePoint {
    std::uint32_t triangle = 0;
    std::array<double, 3> weights{1, 0, 0};  // >= 0, their sum is 1
    double distance = 0;                     // from where the search began, metres
};

// Returns the weights of the point of a triangle that is nearest to `p` (Ericson 2005, Real-Time Collision Detection,
// section 5.1.5).
std::array<double, 3> nearestWeights(Vec3d p, Vec3d a, Vec3d b, Vec3d c);

// A tree of boxes over the triangles. The arrays must outlive it.
class SurfaceTree {
public:
    SurfaceTree(std::span<const Triangle> triangles, std::span<const Vec3> positions);

    // Cost of a point of the surface, added to its squared distance, >= 0. Infinity: it does not count.
    using Cost = std::function<double(std::uint32_t triangle, const std::array<double, 3>& weights)>;
    // Returns the point with the least sum of squared distance and cost; of equal ones that of the first triangle.
    // Unset where no point counts. May be called from many threads.
    std::optional<TreePoint> nearest(Vec3 point, const Cost& cost) const;

    // Returns the share of a ray that passes all triangles, 0..1. `opacity` tells which of them let some through. May
    // be called from many threads.
    double passing(Vec3 origin, Vec3 direction, const Opacity& opacity) const;

private:
    struct Node {
        BoundingBox box;
        std::uint32_t begin = 0, end = 0;  // a leaf: of order_; else end is 0 and begin the first of its two children
    };
    std::span<const Triangle> triangles_;
    std::span<const Vec3> positions_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;

    BoundingBox boxOf(std::uint32_t triangle) const;
    void split(std::uint32_t node, std::uint32_t begin, std::uint32_t end);
};

}  // namespace penumbra
