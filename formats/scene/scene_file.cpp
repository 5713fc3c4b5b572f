#include "formats/scene/scene_file.h"

#include <cctype>
#include <map>
#include <set>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/common/json_node.h"
#include "formats/height/height_file.h"

namespace penumbra {

namespace {

constexpr double kFar = 1e5;  // metres from the origin

SceneCasts readCasts(const JsonNode& node) {
    const std::string word = node.text();
    if (word == "fields") return SceneCasts::kFields;
    if (word == "spheres") return SceneCasts::kSpheres;
    if (word != "nothing") node.fail("must be fields, spheres or nothing");
    return SceneCasts::kNothing;
}

ScenePose readPose(const JsonNode& character, const std::filesystem::path& folder) {
    const JsonNode node = character.at("pose");
    for (const char* other : {"clip", "time"})
        if (character.has(other)) node.fail("cannot stand beside a \"" + std::string(other) + "\": give one of them");
    node.requireKeys({"file", "frame"});
    const std::string file = node.required("file").text();
    if (file.empty()) node.at("file").fail("is empty");
    ScenePose out{node.place(), folder / file, 0};
    if (node.has("frame")) out.frame = std::size_t(node.at("frame").whole(0, 1 << 30));
    return out;
}

// Reads "asset", which "real" stands for where it names a file itself.
void readAsset(const JsonNode& node, const std::filesystem::path& folder, SceneCharacter& out) {
    const bool named = node.has("real") && !node.at("real").isFlag();
    if (named && node.has("asset"))
        node.at("real").fail("names a file, and there is an \"asset\" too: give one of them");
    const JsonNode file = named ? node.at("real") : node.required("asset");
    if (file.text().empty()) file.fail("is empty");
    out.asset = folder / file.text();
    out.real = named || (node.has("real") && node.at("real").flag());
    if (!isRealMesh(out)) return;
    if (!out.real) file.fail("is a mesh, which only a prop that is \"real\" may be");
    for (const char* key : {"material", "slots", "on_ground"})
        if (node.has(key)) node.at(key).fail("is not for a mesh that is real");
}

SceneCharacter readCharacter(const JsonNode& node, const std::filesystem::path& folder, bool moves) {
    if (moves)
        node.requireKeys({"name", "asset", "clip", "time", "pose", "position", "yaw", "scale", "material", "slots",
                          "casts", "on_ground"});
    else
        node.requireKeys(
            {"name", "asset", "position", "yaw", "scale", "material", "slots", "casts", "on_ground", "real"});
    SceneCharacter out;
    out.at = node.place();
    readAsset(node, folder, out);
    if (node.has("name")) {
        out.name = node.at("name").text();
        if (out.name.empty()) node.at("name").fail("is empty");
    }
    if (node.has("clip")) out.clip = node.at("clip").text();
    if (node.has("time")) out.seconds = node.at("time").number(0, 1e6);
    if (node.has("pose")) out.pose = readPose(node, folder);
    if (node.has("position")) out.position = node.at("position").vector(-kFar, kFar);
    if (node.has("on_ground")) out.on_ground = node.at("on_ground").flag();
    if (node.has("yaw")) out.yaw = node.at("yaw").number(-1e4, 1e4);
    if (node.has("scale") && node.at("scale").number(-kFar, kFar) != 1)
        node.at("scale").fail("must be 1: fields and models are made for one size");
    if (node.has("material")) out.material = node.at("material").text();
    if (node.has("slots"))
        for (const auto& [slot, value] : node.at("slots").members()) out.slots.emplace_back(slot, value.text());
    if (node.has("casts")) out.casts = readCasts(node.at("casts"));
    return out;
}

HeightBorder readBorder(const JsonNode& node) {
    const std::string word = node.text();
    if (word == "clamped") return HeightBorder::kClamped;
    if (word == "periodic") return HeightBorder::kPeriodic;
    if (word != "open") node.fail("must be clamped, periodic or open");
    return HeightBorder::kOpen;
}

void readSource(const JsonNode& node, const std::filesystem::path& folder, HeightSource& source) {
    source.at = node.place();
    if (node.has("file") == node.has("analytic")) node.fail("has either a \"file\" or an \"analytic\"");
    for (const char* key : {"rows", "columns"})
        if (node.has(key) && !node.has("analytic")) node.at(key).fail("is only for \"analytic\"; a file has its own");
    for (const char* key : {"array", "no_data", "fill", "fps"})
        if (node.has(key) && !node.has("file")) node.at(key).fail("is only for a \"file\"");
    if (node.has("analytic")) {
        source.analytic = node.at("analytic").text();
        if (source.analytic.empty()) node.at("analytic").fail("is empty");
    } else {
        if (node.at("file").text().empty()) node.at("file").fail("is empty");
        source.file = folder / node.at("file").text();
    }
    if (node.has("rows")) source.rows = node.at("rows").whole(1, kMaxHeightSide);
    if (node.has("columns")) source.columns = node.at("columns").whole(1, kMaxHeightSide);
    if (node.has("array")) source.array = node.at("array").text();
    if (node.has("cell") && node.at("cell").isArray()) node.at("cell").fail("is one number; \"cells\" takes two");
    if (node.has("cell"))
        source.cell_rows = source.cell_columns = node.at("cell").number(double(kMinCell), double(kMaxCell));
    if (node.has("cells")) {  // along x and z, as the vectors of a scene
        if (node.has("cell")) node.at("cells").fail("cannot stand beside a \"cell\": give one of them");
        const std::vector<float> cells = node.at("cells").numbers(2, double(kMinCell), double(kMaxCell));
        source.cell_columns = double(cells[0]);
        source.cell_rows = double(cells[1]);
    }
    if (node.has("scale")) source.scale = node.at("scale").number(-1e9, 1e9);
    if (node.has("offset")) source.offset = node.at("offset").number(-1e9, 1e9);
    if (node.has("border")) source.border = readBorder(node.at("border"));
    if (node.has("no_data")) source.no_data = node.at("no_data").number(-1e30, 1e30);
    if (node.has("fill")) source.fill = node.at("fill").number(-double(kMaxElevation), double(kMaxElevation));
    if (node.has("fps")) source.fps = node.at("fps").number(1e-3, 1e4);
}

// A tolerance, or whether there is one.
double readRefine(const JsonNode& node) {
    if (node.isFlag()) return node.flag() ? double(kHeightTolerance) : 0;
    return node.number(1e-3, double(kMaxHeightTolerance));
}

SceneHeights readHeights(const JsonNode& node, const std::filesystem::path& folder) {
    node.requireKeys({"file", "analytic", "rows", "columns", "array", "cell", "cells", "scale", "offset", "border",
                      "no_data", "fill", "fps", "time", "order", "step", "refine"});
    SceneHeights out;
    readSource(node, folder, out.source);
    if (node.has("time")) out.seconds = node.at("time").number(0, 1e6);
    if (node.has("order")) out.order = node.at("order").whole(4, 5);
    if (node.has("step")) out.step = node.at("step").whole(1, 8);
    if (out.step & (out.step - 1)) node.at("step").fail("must be 1, 2, 4 or 8");
    if (node.has("refine")) out.refine = readRefine(node.at("refine"));
    return out;
}

SceneGround readGround(const JsonNode& node, const std::filesystem::path& folder) {
    node.requireKeys({"height", "centre", "size", "resolution", "albedo", "heights", "material", "catcher", "casts"});
    SceneGround out;
    if (node.has("height")) out.height = node.at("height").number(-kFar, kFar);
    if (node.has("centre")) out.center = node.at("centre").vector(-kFar, kFar);
    if (node.has("size")) out.size = node.at("size").number(1e-3, kFar);
    if (node.has("resolution")) out.resolution = node.at("resolution").whole(2, kMaxGroundResolution);
    if (node.has("albedo")) out.albedo = node.at("albedo").vector(0, 1);
    if (node.has("heights")) out.heights = readHeights(node.at("heights"), folder);
    if (node.has("catcher")) out.catcher = node.at("catcher").flag();
    if (node.has("casts")) out.casts = node.at("casts").flag();
    for (const char* key : {"size", "resolution", "casts"})
        if (node.has(key) && out.heights) node.at(key).fail("is only for a ground without heights");
    if (node.has("material")) {
        if (!out.heights) node.at("material").fail("is only for a ground with heights");
        if (node.has("albedo")) node.at("material").fail("cannot stand beside an \"albedo\": give one of them");
        out.material = node.at("material").text();
    }
    return out;
}

// Reads a camera that is an object: the camera itself, or where its poses stand.
SceneCamera readPhotograph(const JsonNode& node, const std::filesystem::path& folder) {
    SceneCamera out;
    out.at = node.place();
    if (node.has("poses")) {
        node.requireKeys({"poses", "frame"});
        if (node.at("poses").text().empty()) node.at("poses").fail("is empty");
        out.poses = folder / node.at("poses").text();
        if (node.has("frame")) out.frame = std::size_t(node.at("frame").whole(0, 1 << 30));
        return out;
    }
    out.camera = cameraOf(node, {"R", "t"});
    out.pose = poseOf(node);
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

bool isRealMesh(const SceneCharacter& one) {
    std::string extension = one.asset.extension().string();
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    return extension == ".obj" || extension == ".glb";
}

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

namespace {

// Checks that there is a ground where someone stands on it.
void checkOnGround(const SceneDescription& scene) {
    for (const std::vector<SceneCharacter>* list : {&scene.characters, &scene.props})
        for (const SceneCharacter& one : *list)
            if (one.on_ground && !scene.ground) throw InvalidInput(one.at + "/on_ground: the scene has no ground");
}

}  // namespace

SceneDescription parseScene(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
    const nlohmann::json json = parseJson(text, name);
    const JsonNode root(json, name, "");
    root.requireVersion(kSceneFormat);  // before the keys, which another version may not share
    root.requireKeys({"version", "characters", "props", "ground", "light", "camera", "world_scale"});
    SceneDescription scene;
    scene.at = name;
    if (root.has("characters"))
        for (const JsonNode& node : root.at("characters").items(kMaxSceneCharacters))
            scene.characters.push_back(readCharacter(node, folder, true));
    if (root.has("props"))
        for (const JsonNode& node : root.at("props").items(kMaxSceneCharacters))
            scene.props.push_back(readCharacter(node, folder, false));
    if (root.has("ground")) scene.ground = readGround(root.at("ground"), folder);
    if (root.has("light")) scene.light = readLight(root.at("light"), folder);
    if (root.has("camera")) {
        if (root.at("camera").isObject())
            scene.photograph = readPhotograph(root.at("camera"), folder);
        else
            scene.camera = root.at("camera").text();
    }
    if (root.has("world_scale")) scene.world_scale = root.at("world_scale").number(1e-6, 1e6);
    checkOnGround(scene);
    nameAll(scene);
    return scene;
}

namespace {

// Calls add(place, file) for every file that a scene names, maybe again for the same one.
void eachFile(const SceneDescription& scene, const auto& add) {
    for (const std::vector<SceneCharacter>* list : {&scene.characters, &scene.props})
        for (const SceneCharacter& one : *list) {
            add(one.at + "/asset", one.asset);
            if (one.pose) add(one.at + "/pose", one.pose->file);
        }
    if (!scene.light.asset.empty()) add(scene.at + ": /light/asset", scene.light.asset);
    if (scene.photograph && !scene.photograph->poses.empty())
        add(scene.photograph->at + "/poses", scene.photograph->poses);
    if (scene.ground && scene.ground->heights && scene.ground->heights->source.analytic.empty())
        for (const std::filesystem::path& file : filesOf(scene.ground->heights->source))
            add(scene.ground->heights->source.at, file);
}

}  // namespace

std::vector<std::filesystem::path> filesNamedIn(const SceneDescription& scene) {
    std::vector<std::filesystem::path> files;
    std::set<std::filesystem::path> seen;
    eachFile(scene, [&](const std::string&, const std::filesystem::path& file) {
        if (seen.insert(file.lexically_normal()).second) files.push_back(file);
    });
    return files;
}

SceneDescription readScene(const std::filesystem::path& path) {
    SceneDescription scene = parseScene(readJsonText(path), path.string(), path.parent_path());
    eachFile(scene, [](const std::string& place, const std::filesystem::path& file) {
        try {
            checkReadable(file);
        } catch (const IoError& error) {
            throw IoError(place + ": " + error.what());
        }
    });
    return scene;
}

}  // namespace penumbra
