#include "formats/scene/scene_placement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/find_by_name.h"
#include "formats/common/slot_choice.h"
#include "sh/bounding_box.h"
#include "sh/light/light_rotation.h"

namespace penumbra {

namespace {

// Runs what finds things by the names of a command line, for names of a file.
template <class Find>
auto inFile(const Find& find) {
    try {
        return find();
    } catch (const UsageError& error) {
        throw InvalidInput(error.what());
    }
}

}  // namespace

Affine placementOf(const SceneCharacter& one) {
    const double angle = one.yaw * std::numbers::pi / 180;
    const auto c = float(std::cos(angle)), s = float(std::sin(angle));
    const Vec3 p = one.position;
    return {{c, 0, s, p.x, 0, 1, 0, p.y, -s, 0, c, p.z}};
}

std::size_t frameOf(const SceneCharacter& one, const AnimationView& animation, std::optional<double> seconds) {
    if (animation.clips.empty()) throw InvalidInput(one.at + "/asset: " + one.asset.string() + " has no frames");
    const ClipView& clip =
        animation.clips[inFile([&] { return findByName(animation.clips, one.clip, one.at + "/clip"); })];
    const double wanted = seconds.value_or(one.seconds);
    std::size_t best = clip.first_frame;
    for (std::size_t f = clip.first_frame; f < clip.first_frame + clip.frame_count; ++f)
        if (std::abs(animation.times[f] - wanted) < std::abs(animation.times[best] - wanted)) best = f;
    return best;
}

std::vector<std::size_t> materialsOf(const SceneCharacter& one, const AssetView& asset) {
    if (asset.materials.empty()) throw InvalidInput(one.at + "/asset: " + one.asset.string() + " has no material");
    std::vector<std::size_t> material_of_slot(asset.slot_material.begin(), asset.slot_material.end());
    material_of_slot.resize(std::max<std::size_t>(1, asset.mesh.slots.size()));
    const auto find = [&](const std::string& name, const std::string& at) {
        return inFile([&] { return findByName(asset.materials, name, at); });
    };
    if (!one.material.empty())
        std::fill(material_of_slot.begin(), material_of_slot.end(), find(one.material, one.at + "/material"));
    for (const auto& [slot, material] : one.slots) {
        const std::string at = one.at + "/slots/" + slot;
        std::vector<std::size_t> slots;
        try {
            slots = findSlots(asset.mesh.slots, slot);
        } catch (const UsageError& error) {
            throw InvalidInput(at + ": " + error.what());
        }
        for (const std::size_t s : slots) material_of_slot[s] = find(material, at);
    }
    return material_of_slot;
}

const LightView* lightOf(const SceneLight& light, const AssetView& asset) {
    if (!asset.lights.empty())
        return &asset.lights[inFile([&] { return findByName(asset.lights, light.name, light.at + "/name"); })];
    if (!light.name.empty() || !light.asset.empty()) throw InvalidInput(light.at + ": its asset has no light");
    return nullptr;
}

Mat3d rotationOf(const SceneLight& light) {
    try {
        return parseLightRotation(light.rotation);
    } catch (const std::invalid_argument& error) {
        throw InvalidInput(light.at + "/rotation: " + error.what());
    }
}

Camera cameraOf(const SceneDescription& scene, const std::string& option, std::span<const Vec3> points) {
    constexpr double kPitch = 0.25;  // radians: the ground is seen from above
    const double radius = std::max<double>(boundsOf(points).radius(), 1e-3);
    if (option.empty() && scene.photograph)
        throw InvalidInput(scene.photograph->at +
                           ": is the camera of a photograph, which is not drawn by here: give another camera");
    try {
        return makeCamera(option.empty() ? scene.camera : option, points, radius, kPitch, scene.origin);
    } catch (const std::invalid_argument& problem) {
        if (!option.empty()) throw BadOption("camera", problem.what());
        throw InvalidInput(scene.at + ": /camera: " + problem.what());
    }
}

}  // namespace penumbra
