#pragma once
// All that the bake knows of a ray tracer. Only occlusion_embree.cpp includes <embree3/rtcore.h>.
#include <memory>
#include <optional>
#include <span>

#include "bake/ray_directions.h"
#include "formats/common/mesh.h"

namespace penumbra {

struct SurfaceHit {
    std::uint32_t triangle = 0;
    float u = 0, v = 0;  // the point is (1-u-v) a + u b + v c of the triangle's corners
    float distance = 0;
    Vec3 normal;  // of the triangle's front, any length
};

struct Stretch {
    float from, to;  // along a ray
};

// A mesh to shoot rays at. Give it positions of a size near 1 and near the origin (SceneScale): Embree tests in float.
// Triangles with equal corners or no area never block. Every function is safe to call from many threads.
class OcclusionScene {
public:
    // `passing`: nextHit() will be called.
    OcclusionScene(std::span<const Vec3> positions, std::span<const Triangle> triangles, bool passing = false);
    ~OcclusionScene();
    OcclusionScene(OcclusionScene&&) noexcept;
    OcclusionScene& operator=(OcclusionScene&&) noexcept;

    bool occluded(Vec3 origin, Vec3 unit_direction, float min_distance) const;
    std::optional<SurfaceHit> closestHit(Vec3 origin, Vec3 unit_direction) const;
    // The first one on a stretch of the ray, but for triangles with any corner of `passed`.
    std::optional<SurfaceHit> nextHit(Vec3 origin, Vec3 unit_direction, Stretch stretch, const Triangle& passed) const;

    // Rays from `origin` in the directions whose weight is 1: sets the weight of those that hit something to 0.
    // Packets without any such direction are not traced. rays.size() == directions.packets.size().
    void removeOccluded(Vec3 origin, const RayDirections& directions, std::span<LaneWeights> rays) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// Model frame to the ray tracer's: (p - centre) / diagonal, so that a model of 1 mm and one of 1 km, here or far from
// the origin, trace the same rays.
struct SceneScale {
    Vec3d centre;
    double diagonal = 1;

    Vec3 apply(Vec3 p) const { return toFloat((toDouble(p) - centre) / diagonal); }
};
// Centre of the box of `positions`; `diagonal` is the unit of length, > 0.
SceneScale sceneScale(std::span<const Vec3> positions, double diagonal);

}  // namespace penumbra
