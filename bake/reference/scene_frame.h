#pragma once
// Poses everyone of a scene, as one mesh to ray-trace.
#include <memory>

#include "bake/reference/bake_reference.h"
#include "bake/reference/picture_surface.h"
#include "bake/trace/occlusion.h"
#include "formats/scene/scene_file.h"
#include "formats/stage/visibility_file.h"
#include "sh/camera.h"

namespace penumbra {

struct SceneFrame {
    Mesh mesh;  // characters, props, then the ground
    VisibilityFrame frame;
    std::size_t casting_triangles = 0;  // without a level ground
    // The copies of a periodic ground around it cast, but are not seen. Their triangles count vertices of the mesh,
    // then these.
    std::vector<Vec3> unseen_positions;
    std::vector<Triangle> unseen_triangles;
    // Centered on everyone, in diagonals of the smallest of them: on a wide ground rays start as near to a body as on a
    // small one. Unset where nobody has an extent.
    std::optional<SceneScale> scale;
    // No light comes from below: a ground goes on for ever. A level one that casts has a floor, which reflects light.
    bool ends_at_horizon = false;
    std::optional<ReferenceFrame::Floor> floor;
    std::vector<std::string> materials;           // names in the assets; the last is the ground's
    std::vector<std::uint16_t> brdf_of_vertex;    // [V], index into materials
    std::vector<std::uint32_t> member_of_vertex;  // [V], from 1 on; the ground is a member
    std::vector<std::uint32_t> twins;       // [T], as twinTriangles() says; of two the ray tracer meets the first alone
    std::vector<std::uint8_t> front_alone;  // [T] as ReferenceFrame has it
    std::vector<std::shared_ptr<const PictureSurface>> surfaces;  // owners of the surfaces to which `pictures` points
    std::vector<PicturePart> pictures;                            // on the members that have some
    std::vector<std::uint32_t> back_of_vertex;  // [V], what shades the other side; triangles have fronts alone
    Camera camera;
    int light_order = 0;        // 0: the scene has no light
    std::vector<double> light;  // [light_order^2, 3]
    Mat3d light_rotation;
};

enum class SceneLook { kNone, kMaterials, kPictures };  // kPictures: materials, and pictures over them
// Takes meshes, poses, materials and light from the assets. Everyone stands as in penumbra-player render --scene, at
// their own times or all at `seconds`; `camera` as there. The result has its origin near the first member
// (openGround()). Throws what reading assets throws, and InvalidInput for a name in the scene that an asset does not
// have. With kNone, materials may be missing. A slot with pictures has the material "lambert" under them.
SceneFrame poseScene(SceneDescription scene, std::optional<double> seconds, const std::string& camera, SceneLook look);

}  // namespace penumbra
