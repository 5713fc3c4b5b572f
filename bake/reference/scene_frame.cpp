#include "bake/reference/scene_frame.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <numeric>

#include "bake/reference/scene_pictures.h"
#include "formats/asset/asset_file.h"
#include "formats/asset/mapped_file.h"
#include "formats/asset/other_sides.h"
#include "formats/common/errors.h"
#include "formats/common/twin_triangles.h"
#include "formats/scene/bone_poses.h"
#include "formats/scene/scene_origin.h"
#include "formats/scene/scene_placement.h"
#include "sh/character_box.h"

namespace penumbra {

namespace {

struct SceneAsset {
    MappedFile file;
    AssetView view;
    explicit SceneAsset(const std::filesystem::path& path) : file(path), view(openAsset(file.bytes(), path.string())) {}
};

std::vector<Triangle> trianglesOf(std::span<const std::uint32_t> corners) {
    std::vector<Triangle> triangles;
    for (std::size_t t = 0; t < corners.size(); t += 3)
        triangles.push_back({corners[t], corners[t + 1], corners[t + 2]});
    return triangles;
}

// The vertices of a deforming asset in one of its frames.
VisibilityFrame deformAsset(const AssetView& asset, std::size_t frame) {
    VisibilityFrame posed;
    std::vector<Vec3> points(asset.mesh.pointCount());
    readPositions(asset, frame, points);
    for (std::size_t v = 0; v < asset.mesh.positions.size(); ++v)
        posed.positions.push_back(points[asset.mesh.pointOf(v)]);
    posed.normals = vertexNormals(trianglesOf(asset.mesh.triangles), posed.positions);
    return posed;
}

MorphTargets morphsOf(const MorphsView& view) {
    MorphTargets morphs;
    morphs.names.resize(view.count());  // nobody asks for their names
    morphs.rest_weights.assign(view.rest_weights.begin(), view.rest_weights.end());
    morphs.first.assign(view.first.begin(), view.first.end());
    morphs.vertices.assign(view.vertices.begin(), view.vertices.end());
    morphs.positions.assign(view.positions.begin(), view.positions.end());
    morphs.normals.assign(view.normals.begin(), view.normals.end());
    return morphs;
}

Skin skinOf(const AssetView& asset, std::size_t bones) {
    Skin skin;
    skin.joint_names.resize(bones);  // nobody asks for their names
    skin.influences = asset.mesh.influences;
    skin.joints.assign(asset.mesh.skin_joints.begin(), asset.mesh.skin_joints.end());
    skin.weights.assign(asset.mesh.skin_weights.begin(), asset.mesh.skin_weights.end());
    return skin;
}

// The other side of each vertex of an asset, and the twins of its front triangles (empty: none).
struct Sides {
    std::vector<std::uint32_t> other, twins;
};

Sides sidesOf(const AssetView& asset) {
    Sides sides{otherSides(asset.mesh), {}};
    if (asset.mesh.two_sided || asset.mesh.skin_joints.empty()) return sides;
    Mesh mesh;
    mesh.rest_positions.assign(asset.mesh.positions.begin(), asset.mesh.positions.end());
    mesh.triangles = trianglesOf(asset.mesh.triangles);
    sides.twins = twinTriangles(mesh, skinOf(asset, 0));
    if (!sides.twins.empty()) sides.other = twinVertices(mesh, sides.twins);
    return sides;
}

// The vertices of a skinned one in a pose. `inputs` [X] are those of a frame; empty: the bones tell the weights of
// morph targets.
VisibilityFrame skinAsset(const AssetView& asset, std::span<const Affine> bones, std::span<const float> inputs) {
    RestShape posed;
    Mesh mesh;
    mesh.rest_positions.assign(asset.mesh.positions.begin(), asset.mesh.positions.end());
    const Skin skin = skinOf(asset, bones.size());
    const std::size_t morphs = asset.mesh.morphs.count();
    const std::vector<float> weights =
        inputs.empty() ? morphWeights(asset.model.input_joints, bones, asset.animation.input_names.size(), morphs)
                       : std::vector<float>(inputs.end() - std::ptrdiff_t(morphs), inputs.end());
    mesh.morphs = morphsOf(asset.mesh.morphs);
    const std::vector<Affine> all(bones.begin(), bones.end());
    skinMorphed(mesh, skin, {asset.mesh.normals.begin(), asset.mesh.normals.end()}, {all, weights}, posed);
    VisibilityFrame frame;
    frame.positions = std::move(posed.positions);
    frame.normals = std::move(posed.normals);
    return frame;
}

// Puts meshes behind one another.
class SceneMesh {
public:
    // `heights` is null where the ground is level or missing, and outlives this object.
    SceneMesh(SceneFrame& out, const std::optional<SceneGround>& ground, const GroundHeights* heights)
        : out_(out), ground_(ground), heights_(heights) {}

    void add(const SceneCharacter& one, const AssetView& asset, std::optional<double> seconds, SceneLook look) {
        if (!asset.has_mesh) throw InvalidInput(one.at + "/asset: " + one.asset.string() + " has no mesh");
        if (asset.model.deforming && asset.animation.playback.positions.empty())
            throw InvalidInput(one.at + "/asset: " + one.asset.string() + " has no frames");
        const VisibilityFrame posed = poseOf(one, asset, seconds);
        Affine to_scene = placementOf(one);
        to_scene.m[7] += standingHeight(one, posed.positions, to_scene, ground_, heights_);
        const auto first = std::uint32_t(out_.frame.positions.size());
        for (const Vec3 p : posed.positions) out_.frame.positions.push_back(to_scene.point(p));
        for (const Vec3 n : posed.normals) out_.frame.normals.push_back(to_scene.linear() * n);
        const Sides sides = sidesOf(asset);
        for (const std::uint32_t other : sides.other) out_.back_of_vertex.push_back(other + first);
        first_triangle_ = out_.mesh.triangles.size();
        // The ray tracer meets each triangle of a sheet once.
        for (const Triangle& t : trianglesOf(asset.mesh.frontTriangles()))
            out_.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
        for (std::size_t t = first_triangle_; t < out_.mesh.triangles.size(); ++t)
            out_.twins.push_back(
                std::uint32_t(sides.twins.empty() ? t : first_triangle_ + sides.twins[t - first_triangle_]));
        const bool culled = asset.mesh.cull_backs && !asset.mesh.two_sided;
        for (std::size_t t = first_triangle_; t < out_.mesh.triangles.size(); ++t)
            out_.front_alone.push_back(culled && out_.twins[t] == t);
        out_.member_of_vertex.resize(out_.frame.positions.size(), ++members_);
        const std::vector<std::uint16_t> material_of_slot =
            look == SceneLook::kNone ? std::vector<std::uint16_t>(slotCount(asset), 0) : addLook(one, asset, look);
        for (std::size_t v = 0; v < posed.positions.size(); ++v)
            out_.brdf_of_vertex.push_back(
                material_of_slot[asset.mesh.slot_of_vertex.empty() ? 0 : asset.mesh.slot_of_vertex[v]]);
        const BoundingBox box =
            characterBox(asset.mesh.frontTriangles(), std::span(out_.frame.positions).subspan(first));
        corners_.insert(corners_.end(), {box.low, box.high});
        if (box.radius() > 0) least_ = std::min(least_, 2 * box.radius());
    }

    void addGround() {
        const SceneGround& ground = *ground_;
        const auto first = std::uint32_t(out_.frame.positions.size());
        for (const auto& [x, z] : {std::pair{-0.5, -0.5}, {-0.5, 0.5}, {0.5, -0.5}, {0.5, 0.5}})
            out_.frame.positions.push_back(
                toFloat(Vec3d{ground.center.x + x * ground.size, ground.height, ground.center.z + z * ground.size}));
        out_.frame.normals.resize(out_.frame.positions.size(), {0, 1, 0});
        for (std::uint32_t v = first; v < out_.frame.positions.size(); ++v) out_.back_of_vertex.push_back(v);
        out_.mesh.triangles.push_back({first, first + 1, first + 2});
        out_.mesh.triangles.push_back({first + 2, first + 1, first + 3});
        paint(ground);
    }

    void addField() {
        const GroundHeights& heights = *heights_;
        const HeightGrid& grid = heights.field().grid();
        const auto first = std::uint32_t(out_.frame.positions.size());
        for (int r = 0; r < grid.rows; ++r)
            for (int c = 0; c < grid.columns; ++c) {
                out_.back_of_vertex.push_back(std::uint32_t(out_.frame.positions.size()));
                out_.frame.positions.push_back(heights.point(r, c));
                out_.frame.normals.push_back(heights.normal(r, c));
            }
        for (const Triangle& t : trianglesOf(fieldTriangles(grid)))
            out_.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
        paint(*ground_);
        if (grid.border == HeightBorder::kPeriodic) addCopies(*ground_, heights);
    }

    std::span<const Vec3> corners() const { return corners_; }
    std::optional<SceneScale> scale() const {
        if (!(least_ > 0 && std::isfinite(least_))) return std::nullopt;
        return sceneScale(corners_, least_);
    }

private:
    SceneFrame& out_;
    const std::optional<SceneGround>& ground_;
    const GroundHeights* heights_;
    std::vector<Vec3> corners_;                               // corners of all members' boxes
    double least_ = std::numeric_limits<double>::infinity();  // smallest diagonal that is not 0
    PoseFiles poses_;
    ScenePictures pictures_;
    std::size_t first_triangle_ = 0;  // first triangle of the member that is added
    std::uint32_t members_ = 0;

    static std::size_t slotCount(const AssetView& asset) { return std::max<std::size_t>(1, asset.mesh.slots.size()); }

    // Adds a member's pictures. Returns which of the scene's materials each of its slots has.
    std::vector<std::uint16_t> addLook(const SceneCharacter& one, const AssetView& asset, SceneLook look) {
        const std::vector<std::size_t> materials = materialsOf(one, asset);
        std::vector<bool> pictured(materials.size(), false);
        if (look == SceneLook::kPictures) pictured = picturedSlots(asset, materials);
        if (std::ranges::count(pictured, true) > 0) {
            out_.surfaces.push_back(pictures_.surfaceOf(one, asset, pictured));
            out_.pictures.push_back({first_triangle_, out_.surfaces.back().get()});
        }
        std::vector<std::uint16_t> material_of_slot;
        for (std::size_t s = 0; s < materials.size(); ++s)
            material_of_slot.push_back(
                numberOf(pictured[s] ? "lambert" : std::string(asset.materials[materials[s]].name)));
        return material_of_slot;
    }

    // Copies of a periodic field on all sides, as far as horizons are looked for: to the longer side. They join the
    // field and one another by squares from the last line to the next first one.
    void addCopies(const SceneGround& ground, const GroundHeights& heights) {
        constexpr std::size_t kMaxPoints = std::size_t(1) << 25;
        const HeightGrid& grid = heights.field().grid();
        const int longer = std::max(grid.rows, grid.columns), up = (longer + grid.rows - 1) / grid.rows,
                  left = (longer + grid.columns - 1) / grid.columns;
        const HeightGrid all{(2 * up + 1) * grid.rows, (2 * left + 1) * grid.columns};
        if (all.size() > kMaxPoints)
            throw Unsupported(ground.heights->source.at + "/border: the copies of a periodic ground have " +
                              std::to_string(all.size()) + " points, more than can be ray-traced");
        const auto first = std::uint32_t(out_.frame.positions.size());
        const Vec3 corner = heights.corner();
        for (int r = 0; r < all.rows; ++r)
            for (int c = 0; c < all.columns; ++c) {
                const Vec3 p = heights.point(r % grid.rows, c % grid.columns);
                out_.unseen_positions.push_back({corner.x + float(c - left * grid.columns) * grid.cell_y, p.y,
                                                 corner.z + float(r - up * grid.rows) * grid.cell_x});
            }
        const std::vector<Triangle> triangles = trianglesOf(fieldTriangles(all));
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const int square = int(t / 2), r = square / (all.columns - 1) - up * grid.rows,
                      c = square % (all.columns - 1) - left * grid.columns;
            if (r >= 0 && r + 1 < grid.rows && c >= 0 && c + 1 < grid.columns) continue;  // the field itself
            const auto& [a, b, d] = triangles[t];
            out_.unseen_triangles.push_back({a + first, b + first, d + first});
        }
    }

    // Gives the ground's material to all vertices that have none yet.
    void paint(const SceneGround& ground) {
        out_.member_of_vertex.resize(out_.frame.positions.size(), ++members_);
        if (!ground.material.empty()) {
            out_.brdf_of_vertex.resize(out_.frame.positions.size(), numberOf(ground.material));
            return;
        }
        char name[96];
        std::snprintf(name, sizeof name, "lambert:color=%.9g/%.9g/%.9g", double(ground.albedo.x),
                      double(ground.albedo.y), double(ground.albedo.z));
        out_.brdf_of_vertex.resize(out_.frame.positions.size(), numberOf(name));
    }

    VisibilityFrame poseOf(const SceneCharacter& one, const AssetView& asset, std::optional<double> seconds) {
        if (one.pose) return skinAsset(asset, poses_.poseOf(one, asset).bones, {});
        const std::size_t frame = frameOf(one, asset.animation, seconds);
        return asset.model.deforming
                   ? deformAsset(asset, frame)
                   : skinAsset(asset, asset.animation.bonesOf(frame), asset.animation.inputsOf(frame));
    }
    std::uint16_t numberOf(const std::string& material) {
        std::vector<std::string>& all = out_.materials;
        const auto found = std::find(all.begin(), all.end(), material);
        if (found != all.end()) return std::uint16_t(found - all.begin());
        all.push_back(material);
        return std::uint16_t(all.size() - 1);
    }
};

}  // namespace

namespace {

void refuseMesh(const SceneCharacter& one) {
    if (isRealMesh(one)) throw InvalidInput(one.at + ": is a mesh, which only penumbra-player composite takes");
}

// The asset whose light shines on a scene; empty where there is none.
std::filesystem::path lightAssetOf(const SceneDescription& scene) {
    if (!scene.light.asset.empty()) return scene.light.asset;
    if (!scene.characters.empty()) return scene.characters.front().asset;
    return scene.props.empty() ? std::filesystem::path() : scene.props.front().asset;
}

}  // namespace

SceneFrame poseScene(SceneDescription scene, std::optional<double> seconds, const std::string& camera, SceneLook look) {
    std::map<std::filesystem::path, std::unique_ptr<const SceneAsset>> open;
    const auto opened = [&](const std::filesystem::path& path) -> const AssetView& {
        std::unique_ptr<const SceneAsset>& asset = open[path.lexically_normal()];
        if (!asset) asset = std::make_unique<const SceneAsset>(path);
        return asset->view;
    };
    SceneFrame out;
    std::optional<GroundHeights> heights = openGround(scene);
    if (heights) heights->pose(seconds);
    SceneMesh mesh(out, scene.ground, heights ? &*heights : nullptr);
    for (const std::vector<SceneCharacter>* list : {&scene.characters, &scene.props})
        for (const SceneCharacter& one : *list) {
            refuseMesh(one);
            mesh.add(one, opened(one.asset), list == &scene.characters ? seconds : std::nullopt, look);
        }
    if (heights) mesh.addField();
    out.ends_at_horizon = heights && heights->field().grid().border != HeightBorder::kOpen;
    out.casting_triangles = out.mesh.triangles.size();
    if (scene.ground && !heights) mesh.addGround();
    if (scene.ground && !heights && scene.ground->casts) {
        out.ends_at_horizon = true;
        out.floor = {scene.ground->height, scene.ground->albedo};
    }
    while (out.twins.size() < out.mesh.triangles.size()) out.twins.push_back(std::uint32_t(out.twins.size()));
    out.mesh.rest_positions = out.frame.positions;
    out.scale = mesh.scale();
    out.camera = cameraOf(scene, camera, mesh.corners());
    const std::filesystem::path lit_by = lightAssetOf(scene);
    out.light_rotation = rotationOf(scene.light);
    if (lit_by.empty()) return out;
    if (const LightView* light = lightOf(scene.light, opened(lit_by))) {
        out.light_order = light->order;
        out.light.assign(light->sh.begin(), light->sh.end());
    }
    return out;
}

}  // namespace penumbra
