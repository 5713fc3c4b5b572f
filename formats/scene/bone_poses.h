#pragma once
// x.poses.json: poses of a rig as the bones of its assets, which need not be frames of any bake (formats/README.md
// lists the keys). `penumbra-bake poses` writes it, and characters of a scene take their poses from it.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/scene/scene_file.h"

namespace penumbra {

constexpr FileFormat kBonePosesFormat{"penumbra.bone_poses", 1};

struct BonePose {
    std::string clip;
    double time = 0;               // seconds in the clip
    std::vector<Affine> bones;     // [J] skinning matrices
    std::vector<float> rotations;  // [3J] joint rotation vectors relative to rest, radians
};

struct BonePoses {
    std::vector<std::string> joint_names;  // [J], at least one
    std::vector<BonePose> poses;           // at least one
};

std::string bonePosesText(const BonePoses& poses);
BonePoses readBonePoses(const std::filesystem::path& path);  // throws IoError and InvalidInput
// The same for text; `name` stands in messages.
BonePoses parseBonePoses(const std::string& text, const std::string& name);

// Keeps the files that characters take their poses from, so that each is read once.
class PoseFiles {
public:
    // Returns the pose of a character that has one (SceneCharacter::pose), valid as long as this object. Throws what
    // reading throws, and InvalidInput, which names the place in the scene, for a pose that is not there, for one of
    // another rig, and for an asset without a skin.
    const BonePose& poseOf(const SceneCharacter& one, const AssetView& asset);

private:
    std::map<std::filesystem::path, BonePoses> open_;
};

}  // namespace penumbra
