#pragma once
// The posed scene of a reference picture, and the points of its surface.
#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "bake/reference/bake_reference.h"
#include "bake/reference/direct_light.h"

namespace penumbra {

// The frame in the ray tracer's own coordinates.
struct ReferenceScene {
    const ReferenceFrame& input;
    SceneScale scale;
    std::vector<Vec3> positions;
    OcclusionScene scene;                   // for the camera's rays
    std::optional<OcclusionScene> shadows;  // for shadow rays, where they meet more than the camera sees
    std::vector<SampledBrdf> materials;
    double bias = 1e-4;                                       // ReferenceOptions::bias
    int bounces = 0;                                          // ReferenceOptions::bounces
    std::span<const std::optional<Membrane>> membranes = {};  // ReferenceOptions::membranes
    std::optional<PointBrdfs> point_brdfs = {};               // for surfaces with pictures

    const OcclusionScene& blocking() const { return shadows ? *shadows : scene; }
};

// Prepares the scene. It refers to `input`.
ReferenceScene makeReferenceScene(const ReferenceFrame& input, const ReferenceOptions& options, int threads);

// The corners of the triangle that a camera ray meets, and where between them the point lies.
struct Corners {
    Triangle vertex;
    std::array<double, 3> weight;  // barycentric
    std::uint32_t triangle = 0;    // index into Mesh::triangles

    std::uint32_t nearest() const {
        return vertex[std::size_t(std::max_element(weight.begin(), weight.end()) - weight.begin())];
    }
};

// Returns the pictures at a point, and its place in them; null where it has none.
const PictureSurface* picturesAt(const ReferenceFrame& input, const Corners& corners, SurfacePlace& place);

// Returns the corners of the triangle on the side that a ray meets.
Corners cornersOf(const ReferenceFrame& input, const SurfaceHit& hit, Vec3d ray_direction);

// Returns the same point on the other side of a sheet.
Corners otherSide(const ReferenceFrame& input, const Corners& corners);

// Makes the shaded point. Its normal is interpolated. Its shadow rays start on the smooth surface that the normals
// suggest, not on the flat triangle below it, so that triangles do not shadow themselves (Hanika 2021, "Hacking the
// shadow terminator").
SurfacePoint surfacePoint(const ReferenceScene& scene, const Corners& corners, Vec3d to_eye);

}  // namespace penumbra
