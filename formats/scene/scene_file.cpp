#include "formats/scene/scene_file.h"

#include <map>
#include <set>

#include "formats/common/errors.h"
#include "formats/scene/json_node.h"

namespace penumbra {

namespace {

constexpr double kFar = 1e5;  // metres from the origin

SceneCasts readCasts(const JsonNode& node) {
    const std::string word = node.text();
    if (word == "fields") return SceneCasts::kFields;
    if (word == "spheres") return SceneCasts::kSpheres;
    if (word != "nothing") node.fail("is none of fields, spheres and nothing");
    return SceneCasts::kNothing;
}

ScenePose readPose(const JsonNode& character, const std::filesystem::path& folder) {
    const JsonNode node = character.at("pose");
    for (const char* other : {"clip", "time"})
        if (character.has(other)) node.fail("stands beside a \"" + std::string(other) + "\"; one or the other");
    node.requireKeys({"file", "frame"});
    const std::string file = node.required("file").text();
    if (file.empty()) node.at("file").fail("is empty");
    ScenePose out{node.place(), folder / file, 0};
    if (node.has("frame")) out.frame = std::size_t(node.at("frame").whole(0, 1 << 30));
    return out;
}

SceneCharacter readCharacter(const JsonNode& node, const std::filesystem::path& folder, bool moves) {
    if (moves)
        node.requireKeys(
            {"name", "asset", "clip", "time", "pose", "position", "yaw", "scale", "material", "slots", "casts"});
    else
        node.requireKeys({"name", "asset", "position", "yaw", "scale", "material", "slots", "casts"});
    SceneCharacter out;
    out.at = node.place();
    out.asset = folder / node.required("asset").text();
    if (node.at("asset").text().empty()) node.at("asset").fail("is empty");
    if (node.has("name")) {
        out.name = node.at("name").text();
        if (out.name.empty()) node.at("name").fail("is empty");
    }
    if (node.has("clip")) out.clip = node.at("clip").text();
    if (node.has("time")) out.seconds = node.at("time").number(0, 1e6);
    if (node.has("pose")) out.pose = readPose(node, folder);
    if (node.has("position")) out.position = node.at("position").vector(-kFar, kFar);
    if (node.has("yaw")) out.yaw = node.at("yaw").number(-1e4, 1e4);
    if (node.has("scale") && node.at("scale").number(-kFar, kFar) != 1)
        node.at("scale").fail("is not 1; fields and models hold for one size");
    if (node.has("material")) out.material = node.at("material").text();
    if (node.has("slots"))
        for (const auto& [slot, value] : node.at("slots").members()) out.slots.emplace_back(slot, value.text());
    if (node.has("casts")) out.casts = readCasts(node.at("casts"));
    return out;
}

SceneGround readGround(const JsonNode& node) {
    node.requireKeys({"height", "centre", "size", "resolution", "albedo"});
    SceneGround out;
    if (node.has("height")) out.height = node.at("height").number(-kFar, kFar);
    if (node.has("centre")) out.centre = node.at("centre").vector(-kFar, kFar);
    if (node.has("size")) out.size = node.at("size").number(1e-3, kFar);
    if (node.has("resolution")) out.resolution = node.at("resolution").whole(2, kMostGroundResolution);
    if (node.has("albedo")) out.albedo = node.at("albedo").vector(0, 1);
    return out;
}

SceneLight readLight(const JsonNode& node, const std::filesystem::path& folder) {
    node.requireKeys({"asset", "name", "rotation"});
    SceneLight out;
    out.at = node.place();
    if (node.has("asset")) out.asset = folder / node.at("asset").text();
    if (node.has("name")) out.name = node.at("name").text();
    if (node.has("rotation")) out.rotation = node.at("rotation").text();
    return out;
}

}  // namespace

void nameAll(SceneDescription& scene) {
    std::vector<std::pair<SceneCharacter*, std::string>> all;
    for (std::size_t i = 0; i < scene.characters.size(); ++i)
        all.emplace_back(&scene.characters[i], "/characters/" + std::to_string(i));
    for (std::size_t i = 0; i < scene.props.size(); ++i)
        all.emplace_back(&scene.props[i], "/props/" + std::to_string(i));
    std::map<std::string, std::string> where;
    for (const auto& [one, at] : all)
        if (!one->name.empty() && !where.emplace(one->name, at).second)
            throw InvalidInput(scene.at + ": " + at + "/name: \"" + one->name + "\" is also the name of " +
                               where[one->name]);
    std::map<std::string, int> stems;
    for (const auto& [one, at] : all) {
        if (!one->name.empty()) continue;
        const std::string stem = one->asset.stem().string();
        do {
            const int number = ++stems[stem];
            one->name = number == 1 ? stem : stem + "-" + std::to_string(number);
        } while (!where.emplace(one->name, at).second);
    }
}

SceneDescription parseScene(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
    const nlohmann::json json = parseJson(text, name);
    const JsonNode root(json, name, "");
    root.requireKeys({"version", "characters", "props", "ground", "light", "camera"});
    if (const int version = root.required("version").whole(0, 1 << 30); version != kSceneVersion)
        root.at("version").fail("is " + std::to_string(version) + "; this program reads " +
                                std::to_string(kSceneVersion));
    SceneDescription scene;
    scene.at = name;
    if (root.has("characters"))
        for (const JsonNode& node : root.at("characters").items(kMostSceneCharacters))
            scene.characters.push_back(readCharacter(node, folder, true));
    if (root.has("props"))
        for (const JsonNode& node : root.at("props").items(kMostSceneCharacters))
            scene.props.push_back(readCharacter(node, folder, false));
    if (scene.characters.empty()) root.fail("has no characters");
    if (root.has("ground")) scene.ground = readGround(root.at("ground"));
    if (root.has("light")) scene.light = readLight(root.at("light"), folder);
    if (root.has("camera")) scene.camera = root.at("camera").text();
    nameAll(scene);
    return scene;
}

std::vector<std::filesystem::path> filesNamedIn(const SceneDescription& scene) {
    std::vector<std::filesystem::path> files;
    std::set<std::filesystem::path> seen;
    const auto add = [&](const std::filesystem::path& file) {
        if (!file.empty() && seen.insert(file.lexically_normal()).second) files.push_back(file);
    };
    for (const std::vector<SceneCharacter>* list : {&scene.characters, &scene.props})
        for (const SceneCharacter& one : *list) {
            add(one.asset);
            if (one.pose) add(one.pose->file);
        }
    add(scene.light.asset);
    return files;
}

SceneDescription readScene(const std::filesystem::path& path) {
    return parseScene(readJsonText(path), path.string(), path.parent_path());
}

}  // namespace penumbra
