#pragma once
// A scene with its assets open and everyone in a pose.
#include <memory>
#include <optional>

#include "formats/scene/scene_file.h"
#include "player/frame/open_asset.h"
#include "player/runtime/cast_shadow.h"

namespace penumbra {

// A character or a prop.
struct SceneMember {
    const SceneCharacter* file;
    std::shared_ptr<const OpenAsset> asset;
    Evaluator evaluator;
    std::size_t frame = 0;  // of the asset's animation
    Affine to_scene;
    std::size_t caster = kNobody;  // of the cast; kNobody: it hides nothing
};

// Returns what a character casts by; nothing where it casts nothing. Throws InvalidInput where its asset lacks what the
// file wants.
std::optional<CasterKind> casterKindOf(const SceneCharacter& one, const Evaluator& evaluator);

class PosedScene {
public:
    // Opens every asset, each file once, and takes everyone to their times. Throws what OpenAsset throws, and
    // InvalidInput for an asset without a model and for a clip, material or light that is not there.
    explicit PosedScene(SceneDescription file);
    PosedScene(const PosedScene&) = delete;  // casters point to members
    PosedScene& operator=(const PosedScene&) = delete;

    // Takes everyone to their times, or all to one time (seconds into their clips).
    void pose(std::optional<double> seconds);

    const SceneDescription& file() const { return file_; }
    const std::vector<std::unique_ptr<SceneMember>>& members() const { return members_; }
    const CastShadow& cast() const { return *cast_; }
    const AssetView& lightAsset() const { return light_asset_->view; }
    const LightView* light() const { return light_; }  // of lightAsset(); null where that has none
    const Mat3d& lightRotation() const { return light_rotation_; }

private:
    SceneDescription file_;
    std::vector<std::unique_ptr<SceneMember>> members_;  // characters, then props
    std::unique_ptr<CastShadow> cast_;
    std::shared_ptr<const OpenAsset> light_asset_;
    const LightView* light_ = nullptr;
    Mat3d light_rotation_;
};

}  // namespace penumbra
