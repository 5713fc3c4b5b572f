#pragma once
// Renders brute-force pictures of a baked frame to compare the player's with. They use the light at full resolution,
// the true BRDF and shadow rays.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/reference/environment_light.h"
#include "bake/reference/picture_surface.h"
#include "bake/reference/posed_tangents.h"
#include "bake/trace/ray_start.h"
#include "formats/common/progress.h"
#include "formats/stage/visibility_file.h"
#include "sh/brdf/brdf.h"
#include "sh/brdf/membrane.h"
#include "sh/camera.h"

namespace penumbra {

enum class ReferenceChannel { kShaded, kAmbient, kNormals };

struct ReferenceOptions {
    ReferenceChannel channel = ReferenceChannel::kShaded;
    std::vector<RgbBrdf> brdfs = {rgbBrdf({})};  // ReferenceFrame::brdf_of_vertex chooses among them; at least one
    // There is one for each BRDF, or none at all. Where one is set, the BRDF is a white Lambertian surface, and both
    // sides of a sheet are mixed.
    std::vector<std::optional<Membrane>> membranes = {};
    // Radiance that a surface sends out by itself, for each BRDF, or none at all. It is seen, and lights nothing.
    std::vector<Vec3> emissions = {};
    int width = 512, height = 512;        // pixels, each 1..16384
    int samples = 256;                    // shadow rays a pixel, 4..2^20, shared by its camera rays
    int camera_rays = 4;                  // a pixel, 1..64
    int bounces = 0;                      // how often the mesh reflects light, 0..kMaxBounces
    std::optional<Vec3> background = {};  // linear; unset = transparent
    double bias =
        1e-4;  // distance from the surface to the start of a shadow ray, in diagonals of ReferenceFrame::scale
};

// The frame that the picture shows, with its mesh. The infinite floor (header.ground_y, or the level ground of a scene)
// is not drawn, but blocks the light from below.
struct ReferenceFrame {
    const Mesh& mesh;
    const VisibilityFrame& frame;
    bool ground = false;
    std::span<const std::uint16_t> brdf_of_vertex = {};  // [V], index into brdfs; empty: all 0
    const PosedTangents* tangents = nullptr;  // x axes of the BRDFs' frames; null: shadingFrame() makes them up
    // Set for sheets, and with occluders, which are not drawn: rays start by the rules of ray_start.h. If null, rays
    // start at the bias.
    const Blockers* blockers = nullptr;
    std::span<const Vec3> occluder_positions = {};      // positions of the blockers' vertices after those of the mesh
    std::optional<std::size_t> casting_triangles = {};  // set: those behind are seen, but cast no shadow
    // With casting_triangles: what casts but is not seen, with corners among the mesh's vertices and then these.
    std::span<const Vec3> unseen_positions = {};
    std::span<const Triangle> unseen_triangles = {};
    // [V] for a scene, whose triangles are fronts alone, and for a mesh with twins (twin_triangles.h): the vertex of
    // the other side of each one. It is the vertex itself where that is no sheet. In a scene rays of sheets start at
    // the bias as well.
    std::span<const std::uint32_t> back_of_vertex = {};
    std::span<const std::uint32_t> twins = {};  // [T] of a scene, as twinTriangles() says; empty: there are none
    // [T] 1: the camera sees the triangle from its front alone, as the player draws it where
    // other backs of the mesh are triangles of their own. It casts all the same. Empty: all are seen from both sides.
    std::span<const std::uint8_t> front_alone = {};
    std::span<const Vec3> albedo = {};  // [V] what the mesh reflects; needed with bounces
    // [V] what a two-sided mesh sends to the side of the vertex of the light on its other side; empty: nothing
    std::span<const Vec3> transmission = {};
    // [V] of a scene: who a vertex belongs to, from 1 on; empty: all to the same.
    std::span<const std::uint32_t> member_of_vertex = {};
    bool others_alone = false;  // with bounces: a member reflects no light onto itself
    // Pictures on the mesh, which stand in the place of the BRDFs of their triangles.
    std::span<const PicturePart> pictures = {};
    // The ray tracer's frame, of which floats are finest near its center; unset: that of the box of the mesh.
    std::optional<SceneScale> scale = {};
    // Where the floor stands and what it reflects; unset: nothing. It reflects light with bounces.
    struct Floor {
        double height = 0;  // y, in the model's frame
        Vec3 albedo;
    };
    std::optional<Floor> floor = {};
};
// Renders the picture. Its colours are multiplied by coverage, and its alpha is coverage. The same options give the
// same pixels for any number of threads.
Image renderReference(const ReferenceFrame& frame, const Camera& camera, const EnvironmentLight& light,
                      const ReferenceOptions& options, int threads, ProgressStyle progress);

}  // namespace penumbra
