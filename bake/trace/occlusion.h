#pragma once
// All that the bake knows of a ray tracer. Only occlusion_embree.cpp includes embree.h.
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bake/trace/ray_directions.h"
#include "bake/trace/see_through.h"
#include "formats/common/mesh.h"
#include "sh/bounding_box.h"

namespace penumbra {

struct SurfaceHit {
    std::uint32_t triangle = 0;
    float u = 0, v = 0;  // the point is (1-u-v) a + u b + v c of the triangle's corners
    float distance = 0;  // along the ray
    Vec3 normal;         // the normal of the triangle's front, of any length
};

// The first surface that one ray of a set of directions meets.
struct FirstHit {
    std::uint32_t ray = 0;  // kLanes * packet + lane
    std::uint32_t triangle = 0;
    float u = 0, v = 0;  // barycentric, as in SurfaceHit
    bool back = false;   // the ray meets the triangle's back
};

// Which side of a surface a ray meets first.
enum class MetSide : std::uint8_t { kNone, kFront, kBack };
// The side that each of a packet's eight rays met.
struct LaneSides {
    std::array<MetSide, kLanes> lane{};
};

// A part of a ray, by two distances from its origin.
struct Stretch {
    float from, to;
};

// The triangles of a scene that are local to a point: those of the parts with a number other than 0.
struct LocalTriangles {
    std::span<const std::uint16_t> part_of_triangle;  // [T] of the scene
    std::span<const std::uint8_t> is_local;           // [parts]
    // Boxes around the triangles of the first parts, in the space of the scene. No part after them is local.
    std::span<const BoundingBox> box_of_part;

    bool contains(std::uint32_t triangle) const { return is_local[part_of_triangle[triangle]] != 0; }
};

// Which queries a scene is made for: all but nextHit() and removeOccludedLocally(), or those, too.
enum class Queries { kPlain, kFiltered };

// A mesh to shoot rays at. Its positions must be of a size near 1 and near the origin (see SceneScale), because
// Embree tests in float. Triangles with equal corners or without area never block. Every function may be called from
// many threads.
class OcclusionScene {
public:
    // Hits count the triangles as they are given. `through` is read here alone.
    OcclusionScene(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                   Queries queries = Queries::kPlain, const SeeThrough& through = {});
    ~OcclusionScene();
    OcclusionScene(OcclusionScene&&) noexcept;
    OcclusionScene& operator=(OcclusionScene&&) noexcept;

    // Tells whether a ray meets any surface farther away than `min_distance`.
    bool occluded(Vec3 origin, Vec3 unit_direction, float min_distance) const;
    // Returns the first surface on the ray, or nothing.
    std::optional<SurfaceHit> closestHit(Vec3 origin, Vec3 unit_direction) const;
    // Returns the first surface on a stretch of the ray. Triangles with any corner of `passed` do not count.
    std::optional<SurfaceHit> nextHit(Vec3 origin, Vec3 unit_direction, Stretch stretch, const Triangle& passed) const;

    // Traces rays from `origin` in the directions whose weight is 1, and sets the weight of those that hit something
    // to 0. Does not trace packets without any such direction. rays.size() == directions.packets.size(). `reach` has
    // the length of each ray; empty: they have no end.
    void removeOccluded(Vec3 origin, const RayDirections& directions, std::span<LaneWeights> rays,
                        std::span<const LaneWeights> reach = {}) const;
    // Does the same and appends to `hits` what each blocked ray meets first, in the order of the rays.
    void removeOccluded(Vec3 origin, const RayDirections& directions, std::span<LaneWeights> rays,
                        std::vector<FirstHit>& hits) const;
    // Does what removeOccluded() does, with the same result, and at the same time sets to 0 the weights in `near` of
    // those rays that hit a local triangle. Each weight of 1 in `rays` must be 1 in `near` too. A ray that is 1 in
    // `near` alone counts as blocked by something that is not local.
    void removeOccludedLocally(Vec3 origin, const RayDirections& directions, const LocalTriangles& local,
                               std::span<LaneWeights> rays, std::span<LaneWeights> near) const;

    // Finds what each ray from `origin` meets first. The rays of lanes with a zero vector meet nothing. Both sides of a
    // triangle with a twin are fronts, and so are those of the triangles that `sheets` [T] marks; empty: none.
    // sides.size() == packets.size().
    void firstSides(Vec3 origin, std::span<const DirectionPacket> packets, std::span<const std::uint8_t> sheets,
                    std::span<LaneSides> sides) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// Maps the model frame to the ray tracer's by (p - center) / diagonal. A model of 1 mm and one of 1 km, here or far
// from the origin, then trace the same rays.
struct SceneScale {
    Vec3d center;
    double diagonal = 1;

    Vec3 apply(Vec3 p) const { return toFloat((toDouble(p) - center) / diagonal); }
};
// Centers the scale on the box of `positions`. `diagonal` is the unit of length and must be > 0.
SceneScale sceneScale(std::span<const Vec3> positions, double diagonal);

}  // namespace penumbra
