#include "player/scene/side_by_side.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "player/frame/framed_rest.h"
#include "player/frame/open_asset.h"
#include "runtime/papers/refuse_transfer.h"

namespace penumbra {

std::vector<float> placesSideBySide(std::span<const BoundingBox> boxes) {
    float widest = 0;
    for (const BoundingBox& box : boxes) widest = std::max(widest, box.high.x - box.low.x);
    const float middle = 0.5f * float(boxes.size() - 1);
    std::vector<float> places;
    for (std::size_t i = 0; i < boxes.size(); ++i) places.push_back((float(i) - middle) * 4 / 3 * widest);
    return places;
}

SceneGround groundUnder(const BoundingBox& box) {
    constexpr double kRadii = 8;  // side of the ground in radii of the box
    SceneGround ground;
    ground.center = (box.low + box.high) * 0.5f;
    ground.height = double(box.low.y);
    ground.size = std::max(kRadii * box.radius(), 1e-3);
    ground.resolution = kGroundUnderResolution;
    return ground;
}

SceneDescription sceneSideBySide(std::span<const std::filesystem::path> assets) {
    SceneDescription scene;
    std::vector<BoundingBox> boxes;
    for (const std::filesystem::path& path : assets) {
        const OpenAsset asset(path);
        refuseTransfer<InvalidInput>(asset.view, "has linear transfer, on which nothing casts");
        if (!asset.view.has_model) throw InvalidInput(path.string() + ": has no model");
        boxes.push_back(restBox(asset.view));
        SceneCharacter& one = scene.characters.emplace_back();
        one.at = path.string() + ": ";
        one.asset = path;
    }
    const std::vector<float> places = placesSideBySide(boxes);
    BoundingBox all;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Vec3 place{places[i], 0, 0};
        scene.characters[i].position = place;
        const BoundingBox placed{boxes[i].low + place, boxes[i].high + place};
        all = i == 0 ? placed : merged(all, placed);
    }
    scene.ground = groundUnder(all);
    scene.at = assets.front().string();
    scene.light.at = scene.at + ": /light";
    nameAll(scene);
    return scene;
}

}  // namespace penumbra
