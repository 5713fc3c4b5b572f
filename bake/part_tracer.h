#pragma once
// Traces what one rigid part blocks at a point: V - 1 of the part alone as SH over the whole sphere.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "bake/occlusion.h"
#include "bake/part_surface.h"

namespace penumbra {

// A fixed set of directions that fills any cone evenly. Entry i has the share (i + 1/2) / N of the cone's solid angle
// between itself and the axis, and an azimuth.
struct ConeDirections {
    int count = 0;
    std::vector<DirectionPacket> packets;  // x, y: cosine and sine of the azimuth; z: the share; 0 in spare lanes
};
// Seed 1 is the plain set. Any other seed turns it around the axis.
ConeDirections makeConeDirections(int count, std::uint64_t seed);

// What a part blocks at a point. A point inside the part holds what the nearest surface point sees.
struct PointOfField {
    std::array<float, kFieldNumbers> blocked{};  // V - 1
    float distance = 0;  // from the surface, < 0 inside, in the unit of the mesh; only where it is asked for
};

// Traces points around one part. Any number of threads may call trace().
class PartTracer {
public:
    // `mesh` has at least one triangle with an area.
    PartTracer(const PartMesh& mesh, const PartField& field, const ConeDirections& directions);
    PointOfField trace(Vec3 point, bool with_distance) const;

private:
    struct Seen {
        std::array<double, kFieldNumbers> blocked{};
        double back_share = 0;  // of all directions of the sphere that meet the back of a triangle first
    };
    Seen see(Vec3 scaled_point) const;

    const ConeDirections& directions_;
    SceneScale scale_;
    Vec3d centre_;  // of the bounding sphere, scaled
    double radius_ = 0;
    OcclusionScene scene_;
    NearestSurface surface_;
};

}  // namespace penumbra
