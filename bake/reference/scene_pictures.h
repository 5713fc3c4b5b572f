#pragma once
// The pictures on the members of a scene, as their assets store them.
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bake/reference/picture_surface.h"
#include "formats/asset/asset_file.h"
#include "formats/scene/scene_file.h"

namespace penumbra {

// Tells for each slot of an asset whether its pictures are seen: where the scene gives it no other material.
// `material_of_slot` [slots] is what materialsOf() says.
std::vector<bool> picturedSlots(const AssetView& asset, const std::vector<std::size_t>& material_of_slot);

// Opens pictures, those of an asset once, however often it stands in the scene with the same slots.
class ScenePictures {
public:
    // Throws what reading pictures throws. `asset` has a surface.
    std::shared_ptr<const PictureSurface> surfaceOf(const SceneCharacter& one, const AssetView& asset,
                                                    const std::vector<bool>& pictured);

private:
    std::map<std::pair<const AssetView*, std::vector<bool>>, std::shared_ptr<const PictureSurface>> opened_;
};

}  // namespace penumbra
