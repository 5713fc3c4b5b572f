#pragma once
// The box by which the player frames a character before it is posed.
#include "formats/asset/asset_file.h"
#include "formats/common/rest_in_scene.h"
#include "sh/character_box.h"

namespace penumbra {

// Returns the vertices [V] of an asset at rest in the scene (rest_in_scene.h).
inline std::vector<Vec3> framedRest(const AssetView& asset) {
    const AnimationView& animation = asset.animation;
    const bool posed = !asset.model.deforming && animation.frameCount() > 0;
    return restInScene(asset.mesh.positions, {asset.mesh.influences, asset.mesh.skin_joints, asset.mesh.skin_weights},
                       posed ? animation.bonesOf(0) : std::span<const Affine>());
}
// Returns the box of the character alone, of vertices [V] that are posed or not.
inline BoundingBox framedBox(const AssetView& asset, std::span<const Vec3> positions) {
    return characterBox(asset.mesh.frontTriangles(), positions);
}
inline BoundingBox restBox(const AssetView& asset) { return framedBox(asset, framedRest(asset)); }

}  // namespace penumbra
