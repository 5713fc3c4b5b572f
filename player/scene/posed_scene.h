#pragma once
// A scene with its assets open and everyone in a pose.
#include <memory>
#include <optional>

#include "formats/scene/bone_poses.h"
#include "player/frame/frame_values.h"
#include "player/frame/open_asset.h"
#include "player/papers/cast_way.h"
#include "player/scene/scene_field.h"
#include "runtime/cast/cast_shadow.h"

namespace penumbra {

// A character or a prop.
struct SceneMember {
    const SceneCharacter* file;
    std::shared_ptr<const OpenAsset> asset;
    Evaluator evaluator;
    std::size_t frame = 0;  // index in the asset's animation; 0 with a pose of a file
    Affine to_scene;
    std::size_t caster = kNobody;    // index in the cast; kNobody: it hides nothing
    const BonePose* pose = nullptr;  // pose of a file, instead of a frame
};

// A prop that is a mesh of a file.
struct RealMesh {
    const SceneCharacter* file;
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> triangles;  // [3 T]
};

// Tells whether a member casts into the maps of suns: all but those whom the file says cast nothing.
inline bool castsInSuns(const SceneCharacter& one) { return one.casts != SceneCasts::kNothing; }

// Returns what a character casts by; nothing where it casts nothing. Throws InvalidInput where its asset lacks what the
// file wants.
std::optional<CasterKind> casterKindOf(const SceneCharacter& one, const Evaluator& evaluator);

class PosedScene {
public:
    // Opens every asset, each file once, and takes everyone to their times. Throws what OpenAsset throws, InvalidInput
    // for an asset without a model, for a clip, pose, material or light that is not there and for one without the
    // casters that `way` needs, and UsageError for an exponential where nobody casts by spheres.
    explicit PosedScene(SceneDescription file, const CastWay& way = {});
    PosedScene(const PosedScene&) = delete;  // casters point to members
    PosedScene& operator=(const PosedScene&) = delete;

    // Takes everyone to their times, or all to one time (seconds into their clips), and so the heights of the ground.
    // Props stay, and so does who has a pose of a file. Who stands on the ground goes up and down with what
    // lies below the pose.
    void pose(std::optional<double> seconds);

    // Gives the light a dark sun where it has none, so that a light with a sun can take its place later
    // (SceneFrames::replaceLight()). Call it before anything is made of the light.
    void addDarkSun();

    // The scene as read; its origin was moved near the first member (openGround()).
    const SceneDescription& file() const { return file_; }
    const std::vector<std::unique_ptr<SceneMember>>& members() const { return members_; }
    const CastShadow& cast() const { return *cast_; }
    // The heights of the ground, which remember what they have looked at; null where it is level or missing.
    SceneField* field() const { return field_.get(); }
    // There is a level ground that hides light from members and sends light back.
    bool groundCasts() const {
        return file_.ground && !field_ && file_.ground->casts && way_.mode == CastMode::kProduct;
    }
    const CastWay& castWay() const { return way_; }
    // Props that are meshes, in the scene. They never move.
    const std::vector<RealMesh>& realMeshes() const { return meshes_; }
    // An asset without anything where there is no member and the file names no other.
    const AssetView& lightAsset() const {
        return has_dark_sun_ ? dark_asset_ : light_asset_ ? light_asset_->view : no_asset_;
    }
    const LightView* light() const { return light_; }  // the light of lightAsset(); null if that has none
    const Mat3d& lightRotation() const { return light_rotation_; }

private:
    CastWay way_;
    SceneDescription file_;
    PoseFiles poses_;
    std::vector<std::unique_ptr<SceneMember>> members_;  // characters, then props
    std::unique_ptr<CastShadow> cast_;
    std::unique_ptr<SceneField> field_;
    std::shared_ptr<const OpenAsset> light_asset_;
    AssetView no_asset_;
    AssetView dark_asset_;  // light_asset_ with a dark sun
    bool has_dark_sun_ = false;
    std::vector<RealMesh> meshes_;
    const LightView* light_ = nullptr;
    Mat3d light_rotation_;
    FrameVertices standing_;  // scratch for the pose of a character that stands on the ground

    void place(SceneMember& member);
};

}  // namespace penumbra
