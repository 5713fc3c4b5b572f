#include "formats/scene/bone_poses.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/json_node.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxPoses = 1000000, kMaxJoints = 65535;
constexpr double kFarthestBone = 1e6, kMaxRadians = 1e3;

BonePose readBonePose(const JsonNode& node, std::size_t joints) {
    node.requireKeys({"clip", "time", "bones", "rotations"});
    BonePose out;
    if (node.has("clip")) out.clip = node.at("clip").text();
    if (node.has("time")) out.time = node.at("time").number(0, 1e6);
    const auto rows = [&](const char* key) {
        std::vector<JsonNode> all = node.required(key).items(joints);
        if (all.size() != joints) node.at(key).fail("must have " + std::to_string(joints) + " rows, one a joint");
        return all;
    };
    for (const JsonNode& row : rows("bones")) {
        const std::vector<float> numbers = row.numbers(12, -kFarthestBone, kFarthestBone);
        std::copy(numbers.begin(), numbers.end(), out.bones.emplace_back().m.begin());
    }
    for (const JsonNode& row : rows("rotations")) {
        const std::vector<float> numbers = row.numbers(3, -kMaxRadians, kMaxRadians);
        out.rotations.insert(out.rotations.end(), numbers.begin(), numbers.end());
    }
    return out;
}

void checkRig(const SceneCharacter& one, const AssetView& asset, const BonePoses& poses) {
    const auto fail = [&](const std::string& what) {
        throw InvalidInput(one.pose->at + ": " + one.pose->file.string() + " " + what);
    };
    if (asset.model.deforming) fail("has bones, and " + one.asset.string() + " is a cloth, which has none");
    const std::vector<std::string_view>& names = asset.animation.joint_names;
    if (poses.joint_names.size() != names.size())
        fail("has " + std::to_string(poses.joint_names.size()) + " joints, and " + one.asset.string() + " has " +
             std::to_string(names.size()));
    for (std::size_t j = 0; j < names.size(); ++j)
        if (poses.joint_names[j] != names[j])
            fail("is of another rig: its joint " + std::to_string(j) + " is \"" + poses.joint_names[j] +
                 "\", and that of " + one.asset.string() + " is \"" + std::string(names[j]) + "\"");
    if (asset.model.features != FeatureKind::kRelativeBones && asset.animation.pose_size != 3 * names.size())
        fail("has no other numbers than joint rotations, and the model of " + one.asset.string() + " reads some");
    if (one.pose->frame >= poses.poses.size())
        fail("has " + std::to_string(poses.poses.size()) + " poses, so none of number " +
             std::to_string(one.pose->frame));
}

}  // namespace

std::string bonePosesText(const BonePoses& poses) {
    using Json = nlohmann::ordered_json;
    Json list = Json::array();
    for (const BonePose& pose : poses.poses) {
        Json& one = list.emplace_back(Json{{"clip", pose.clip}, {"time", pose.time}});
        for (const Affine& bone : pose.bones) one["bones"].push_back(bone.m);
        for (std::size_t j = 0; j < pose.bones.size(); ++j)
            one["rotations"].push_back({pose.rotations[3 * j], pose.rotations[3 * j + 1], pose.rotations[3 * j + 2]});
    }
    const Json json{{"format", kBonePosesFormat.name},
                    {"version", kBonePosesFormat.version},
                    {"joints", poses.joint_names},
                    {"poses", std::move(list)}};
    return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

BonePoses parseBonePoses(const std::string& text, const std::string& name) {
    const nlohmann::json json = parseJson(text, name);
    const JsonNode root(json, name, "");
    if (const std::string found = root.required("format").text(); found != kBonePosesFormat.name)
        root.at("format").fail("is \"" + found + "\", and not \"" + kBonePosesFormat.name + "\"");
    root.requireVersion(kBonePosesFormat);  // before the keys, which another version may not share
    root.requireKeys({"format", "version", "joints", "poses"});
    BonePoses out;
    for (const JsonNode& joint : root.required("joints").items(kMaxJoints)) out.joint_names.push_back(joint.text());
    if (out.joint_names.empty()) root.at("joints").fail("is empty");
    for (const JsonNode& pose : root.required("poses").items(kMaxPoses))
        out.poses.push_back(readBonePose(pose, out.joint_names.size()));
    if (out.poses.empty()) root.at("poses").fail("is empty");
    return out;
}

BonePoses readBonePoses(const std::filesystem::path& path) { return parseBonePoses(readJsonText(path), path.string()); }

const BonePose& PoseFiles::poseOf(const SceneCharacter& one, const AssetView& asset) {
    const auto [found, is_new] = open_.try_emplace(one.pose->file.lexically_normal());
    if (is_new) found->second = readBonePoses(one.pose->file);
    checkRig(one, asset, found->second);
    return found->second.poses[one.pose->frame];
}

}  // namespace penumbra
