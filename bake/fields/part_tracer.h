#pragma once
// Traces what one rigid part blocks at a point: V - 1 of the part alone as SH over the whole sphere.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "bake/fields/part_surface.h"
#include "bake/trace/occlusion.h"

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
    std::array<float, kFieldCoefficients> blocked{};  // V - 1
    // From the surface, < 0 inside, in the unit of the mesh; only where it is asked for. `depth` is > 0 inside, and by
    // how much (closeHoles()).
    float distance = 0, depth = 0;
};

// Whether the distance from the surface is wanted of every point, or only of those inside, which need it.
enum class Distances { kAll, kInside };

// Traces points around one part. Any number of threads may call trace().
//
// A point is inside where many rays meet the backs of triangles, or where hardly any ray escapes: a mouth is no place
// for a hand. Triangles that see inside or into a deep fold, such as teeth and ears do, are no surface that distances
// count from.
//
// Only a closed surface has an inside. A triangle with other backs behind it is part of one, though it may have holes
// where the part joins others. A triangle with no such thing behind it is a sheet, as a cape or a leaf is: there is
// nothing to be inside of, so its back is one more surface that light reaches.
class PartTracer {
public:
    // `mesh` has at least one triangle with an area.
    PartTracer(const PartMesh& mesh, const PartField& field, const ConeDirections& directions);
    PointOfField trace(Vec3 point, Distances wanted) const;

private:
    struct Seen {
        std::array<double, kFieldCoefficients> blocked{};
        double depth = 0;    // > 0: inside
        double backs = 0;    // share of all directions of the sphere that meets the back of a closed surface
        double escaped = 0;  // share of all directions of the sphere that meets nothing
    };
    Seen see(Vec3 scaled_point, const ConeDirections& directions, std::span<const std::uint8_t> sheets) const;
    std::vector<std::uint8_t> findSheets(const PartMesh& mesh) const;
    std::vector<Triangle> exposed(std::span<const Vec3> scaled_positions, std::span<const Triangle> triangles) const;

    const ConeDirections& directions_;
    SceneScale scale_;
    Vec3d center_;  // of the bounding sphere, scaled
    double radius_ = 0;
    OcclusionScene scene_;
    std::vector<std::uint8_t> sheets_;  // [T] 1: a sheet
    NearestSurface surface_;
};

}  // namespace penumbra
