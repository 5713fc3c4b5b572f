#include "formats/scene/scene_file.h"

#include <cmath>
#include <fstream>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "formats/common/errors.h"
#include "formats/common/json_depth.h"

namespace penumbra {

namespace {

using Json = nlohmann::json;
constexpr std::uintmax_t kMostBytes = 64 << 20;
constexpr double kFar = 1e5;  // metres from the origin

// A value and where it stands, for messages.
class Node {
public:
    Node(const Json& json, std::string file, std::string at)
        : json_(&json), file_(std::move(file)), at_(std::move(at)) {}

    [[noreturn]] void fail(const std::string& what) const {
        throw InvalidInput(file_ + ": " + (at_.empty() ? "/" : at_) + ": " + what);
    }
    // Keys of a file go to the terminal.
    static std::string printable(std::string key) {
        for (char& c : key)
            if (static_cast<unsigned char>(c) < 0x20) c = '?';
        return key;
    }
    void requireKeys(std::initializer_list<const char*> known) const {
        if (!json_->is_object()) fail("must be an object");
        for (const auto& [key, value] : json_->items()) {
            bool found = false;
            for (const char* name : known) found = found || key == name;
            if (!found) at(printable(key)).fail("unknown key");
        }
    }
    std::string place() const { return file_ + ": " + at_; }
    bool has(const char* key) const { return json_->contains(key); }
    Node at(const std::string& key) const {
        return {json_->contains(key) ? json_->at(key) : *json_, file_, at_ + "/" + key};
    }
    std::vector<Node> items(std::size_t most) const {
        if (!json_->is_array()) fail("must be an array");
        if (json_->size() > most)
            fail("has " + std::to_string(json_->size()) + " elements; at most " + std::to_string(most));
        std::vector<Node> nodes;
        for (std::size_t i = 0; i < json_->size(); ++i)
            nodes.emplace_back((*json_)[i], file_, at_ + "/" + std::to_string(i));
        return nodes;
    }
    std::vector<std::pair<std::string, Node>> members() const {
        if (!json_->is_object()) fail("must be an object");
        std::vector<std::pair<std::string, Node>> nodes;
        for (const auto& [key, value] : json_->items()) nodes.emplace_back(key, Node(value, file_, at_ + "/" + key));
        return nodes;
    }
    std::string text() const {
        if (!json_->is_string()) fail("must be a string");
        const auto text = json_->get<std::string>();
        if (std::ranges::any_of(text, [](unsigned char c) { return c < 0x20; })) fail("has a control character");
        return text;
    }
    double number(double low, double high) const {
        if (!json_->is_number()) fail("must be a number");
        const auto x = json_->get<double>();
        if (!(x >= low && x <= high)) {
            std::ostringstream range;
            range << "is " << x << ", not in [" << low << ", " << high << "]";
            fail(range.str());
        }
        return x;
    }
    int whole(int low, int high) const {
        if (!json_->is_number_integer()) fail("must be a whole number");
        return int(number(low, high));
    }
    Vec3 vector(double low, double high) const {
        const std::vector<Node> three = items(3);
        if (three.size() != 3) fail("must have 3 numbers");
        return {float(three[0].number(low, high)), float(three[1].number(low, high)),
                float(three[2].number(low, high))};
    }

private:
    const Json* json_;
    std::string file_, at_;
};

// Parses without recursion of ours, and refuses a key that stands twice in one object, which would hide the first.
Json parse(const std::string& text, const std::string& name) {
    if (nestedTooDeep(text)) throw InvalidInput(name + ": nested too deep");
    std::vector<std::set<std::string>> keys;
    const auto watch = [&](int, Json::parse_event_t event, Json& value) {
        if (event == Json::parse_event_t::object_start) keys.emplace_back();
        if (event == Json::parse_event_t::object_end) keys.pop_back();
        if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
            throw InvalidInput(name + ": the key \"" + value.get<std::string>() + "\" stands twice in one object");
        return true;
    };
    try {
        return Json::parse(text, watch);
    } catch (const Json::exception& error) {
        throw InvalidInput(name + ": not JSON: " + error.what());
    }
}

SceneCasts readCasts(const Node& node) {
    const std::string word = node.text();
    if (word == "fields") return SceneCasts::kFields;
    if (word == "spheres") return SceneCasts::kSpheres;
    if (word != "nothing") node.fail("is none of fields, spheres and nothing");
    return SceneCasts::kNothing;
}

SceneCharacter readCharacter(const Node& node, const std::filesystem::path& folder, bool moves) {
    if (moves)
        node.requireKeys({"name", "asset", "clip", "time", "position", "yaw", "scale", "material", "slots", "casts"});
    else
        node.requireKeys({"name", "asset", "position", "yaw", "scale", "material", "slots", "casts"});
    SceneCharacter out;
    out.at = node.place();
    if (!node.has("asset")) node.fail("has no \"asset\"");
    out.asset = folder / node.at("asset").text();
    if (node.at("asset").text().empty()) node.at("asset").fail("is empty");
    if (node.has("name")) {
        out.name = node.at("name").text();
        if (out.name.empty()) node.at("name").fail("is empty");
    }
    if (node.has("clip")) out.clip = node.at("clip").text();
    if (node.has("time")) out.seconds = node.at("time").number(0, 1e6);
    if (node.has("position")) out.position = node.at("position").vector(-kFar, kFar);
    if (node.has("yaw")) out.yaw = node.at("yaw").number(-1e4, 1e4);
    if (node.has("scale")) node.at("scale").number(1, 1);
    if (node.has("material")) out.material = node.at("material").text();
    if (node.has("slots"))
        for (const auto& [slot, value] : node.at("slots").members()) out.slots.emplace_back(slot, value.text());
    if (node.has("casts")) out.casts = readCasts(node.at("casts"));
    return out;
}

SceneGround readGround(const Node& node) {
    node.requireKeys({"height", "centre", "size", "resolution", "albedo"});
    SceneGround out;
    if (node.has("height")) out.height = node.at("height").number(-kFar, kFar);
    if (node.has("centre")) out.centre = node.at("centre").vector(-kFar, kFar);
    if (node.has("size")) out.size = node.at("size").number(1e-3, kFar);
    if (node.has("resolution")) out.resolution = node.at("resolution").whole(2, kMostGroundResolution);
    if (node.has("albedo")) out.albedo = node.at("albedo").vector(0, 1);
    return out;
}

SceneLight readLight(const Node& node, const std::filesystem::path& folder) {
    node.requireKeys({"asset", "name", "rotation"});
    SceneLight out;
    out.at = node.place();
    if (node.has("asset")) out.asset = folder / node.at("asset").text();
    if (node.has("name")) out.name = node.at("name").text();
    if (node.has("rotation")) out.rotation = node.at("rotation").text();
    return out;
}

// Names what has no name, and refuses names that stand twice.
void nameAll(SceneDescription& scene, const std::string& file) {
    std::vector<std::pair<SceneCharacter*, std::string>> all;
    for (std::size_t i = 0; i < scene.characters.size(); ++i)
        all.emplace_back(&scene.characters[i], "/characters/" + std::to_string(i));
    for (std::size_t i = 0; i < scene.props.size(); ++i)
        all.emplace_back(&scene.props[i], "/props/" + std::to_string(i));
    std::map<std::string, std::string> where;
    for (const auto& [one, at] : all)
        if (!one->name.empty() && !where.emplace(one->name, at).second)
            throw InvalidInput(file + ": " + at + "/name: \"" + one->name + "\" is also the name of " +
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

}  // namespace

SceneDescription parseScene(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
    const Json json = parse(text, name);
    const Node root(json, name, "");
    root.requireKeys({"version", "characters", "props", "ground", "light", "camera"});
    if (!root.has("version")) root.fail("has no \"version\"");
    if (const int version = root.at("version").whole(0, 1 << 30); version != kSceneVersion)
        root.at("version").fail("is " + std::to_string(version) + "; this program reads " +
                                std::to_string(kSceneVersion));
    SceneDescription scene;
    scene.at = name;
    if (root.has("characters"))
        for (const Node& node : root.at("characters").items(kMostSceneCharacters))
            scene.characters.push_back(readCharacter(node, folder, true));
    if (root.has("props"))
        for (const Node& node : root.at("props").items(kMostSceneCharacters))
            scene.props.push_back(readCharacter(node, folder, false));
    if (scene.characters.empty()) root.fail("has no characters");
    if (root.has("ground")) scene.ground = readGround(root.at("ground"));
    if (root.has("light")) scene.light = readLight(root.at("light"), folder);
    if (root.has("camera")) scene.camera = root.at("camera").text();
    nameAll(scene, name);
    return scene;
}

SceneDescription readScene(const std::filesystem::path& path) {
    std::error_code problem;
    const std::uintmax_t size = std::filesystem::file_size(path, problem);
    if (problem) throw IoError(path.string() + ": " + problem.message());
    if (size > kMostBytes)
        throw InvalidInput(path.string() + ": has " + std::to_string(size) + " bytes; a scene has at most " +
                           std::to_string(kMostBytes));
    std::ifstream file(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), {});
    if (!file) throw IoError(path.string() + ": cannot be read");
    return parseScene(text, path.string(), path.parent_path());
}

}  // namespace penumbra
