#pragma once
// The visibility past the spheres of casters, for many receivers at once. It is what netLog() and expOfLog() with its
// default options give, computed for 8 receivers at a time (docs/formulas.md, section 10).
#include <span>

#include "sh/cast/cap_visibility.h"
#include "sh/cast/cast_kernel.h"

namespace penumbra {

// Writes the visibility past all `spheres` at each position, over the whole sphere of directions and in the frame of
// the spheres: out[r * order^2 + i]. `order` is from kMinLogOrder to kMaxLogOrder. Allocates nothing, but the first
// call of an order makes its tables.
void castVisibility(int order, std::span<const CasterSphere> spheres, std::span<const Vec3> positions,
                    std::span<float> out, const CastPath& path = fastestCastPath());

// Points with unit normals and unit tangents orthogonal to them.
struct CastPoints {
    std::span<const Vec3> positions, normals, tangents;
};
// A sphere whose (r / 2d)^2, the share of all directions that it hides from afar, is below `least` does not count, and
// one above `full` counts whole, so that spheres fade out with distance. With `full` they also fade up to their
// centers.
struct CastFade {
    float least = 0, full = 0;
};
constexpr std::size_t kMirroredCast = 21;
constexpr int kCastOrder = 5;  // order of the spheres' logarithms

// Writes the visibility past all `spheres` in each point's local frame, mirrored at its horizon (sh/mirrored_product.h,
// order 6): out[r * kMirroredCast + i]. Allocates nothing, but the first call makes its tables.
void castMirrored(std::span<const CasterSphere> spheres, const CastPoints& points, const CastFade& fade,
                  std::span<float> out, const CastPath& path = fastestCastPath());
// The same, if castAnchors() has summed the spheres that are not near. `spheres` holds every sphere near some anchor,
// including those in the anchors' lists.
void castMirrored(std::span<const CasterSphere> spheres, const FarAnchors& anchors, const CastPoints& points,
                  const CastFade& fade, std::span<float> out, const CastPath& path = fastestCastPath());

// Writes the values of anchors (sh/far/far_kernel.h) at the positions: the sum of logarithms in the frame of the
// spheres, and how near each sphere is, for anchors so far apart: out[a * anchorStride(spheres.size()) + i].
void castAnchors(std::span<const CasterSphere> spheres, std::span<const Vec3> positions, float spacing,
                 const CastFade& fade, std::span<float> out, const CastPath& path = fastestCastPath());

}  // namespace penumbra
