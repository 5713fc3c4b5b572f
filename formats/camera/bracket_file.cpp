#include "formats/camera/bracket_file.h"

#include <algorithm>
#include <sstream>

#include "formats/camera/camera_file.h"
#include "formats/common/json_node.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxPictures = 100000;
constexpr double kMinExposure = 1e-12, kMaxExposure = 1e12;

// Returns a file that JSON names, as seen from the folder of the JSON file.
std::filesystem::path besideFile(const std::string& json_file, const JsonNode& node) {
    const std::string text = node.text();
    if (text.empty()) node.fail("is empty");
    return std::filesystem::path(json_file).parent_path() / text;
}

// Returns the name of a known curve or "find" as it is, and any other text as a path.
std::string responseOf(const std::string& json_file, const JsonNode& root) {
    if (!root.has("response")) return "";
    const JsonNode node = root.at("response");
    const std::string text = node.text();
    if (text == "find" || knownResponse(text)) return text;
    return besideFile(json_file, node).string();
}

ExposedPicture readPicture(const std::string& json_file, const JsonNode& node) {
    ExposedPicture out;
    out.file = besideFile(json_file, node.required("file"));
    out.exposure = node.required("exposure").number(kMinExposure, kMaxExposure);
    return out;
}

// Refuses exposures that neither all rise nor all fall: then a picture was named at the wrong place, or its exposure is
// not its own.
void requireOrder(const std::vector<ExposedPicture>& pictures, const std::vector<JsonNode>& nodes) {
    const bool rise = pictures[1].exposure > pictures[0].exposure;
    for (std::size_t k = 1; k < pictures.size(); ++k) {
        const double before = pictures[k - 1].exposure, here = pictures[k].exposure;
        std::ostringstream what;
        if (here == before)
            what << "is " << here << " like the one before: every picture of a bracket needs an exposure of its own";
        else if ((here > before) != rise)
            what << "is " << here << " after " << before << ": the exposures of a bracket must all rise or all fall";
        if (!what.str().empty()) nodes[k].at("exposure").fail(what.str());
    }
}

// Returns the pose that a track has of a file of this name, without folders.
CameraPose poseNamed(const CameraTrack& track, const std::filesystem::path& file, const JsonNode& picture) {
    for (const TrackFrame& frame : track.frames)
        if (frame.pose && std::filesystem::path(frame.file).filename() == file.filename()) return *frame.pose;
    picture.at("file").fail("no frame of \"poses\" that has a pose is called " + file.filename().string());
}

void readCommon(const JsonNode& root, BracketFile& out) {
    if (root.has("camera")) out.camera = cameraOrFile(root.at("camera"), out.name);
    out.response = responseOf(out.name, root);
}

}  // namespace

BracketFile parseBracket(const std::string& text, const std::string& name) {
    const nlohmann::json json = parseJson(text, name);
    const JsonNode root(json, name, "");
    root.requireKeys({"camera", "response", "tag", "R", "t", "pictures"});
    BracketFile out;
    out.name = name;
    readCommon(root, out);
    if (root.has("tag")) out.tag = root.at("tag").text();
    if (root.has("R") || root.has("t")) {
        if (root.has("tag")) root.fail("has a \"tag\" and a pose (\"R\", \"t\"): give one of them");
        out.pose = poseOf(root);
    }
    const std::vector<JsonNode> nodes = root.required("pictures").items(kMaxPictures);
    for (const JsonNode& node : nodes) {
        node.requireKeys({"file", "exposure"});
        out.pictures.push_back(readPicture(name, node));
    }
    if (nodes.size() < 2)
        root.at("pictures").fail("has " + std::to_string(nodes.size()) + " pictures: a bracket has at least 2");
    requireOrder(out.pictures, nodes);
    return out;
}

BracketFile readBracket(const std::filesystem::path& path) { return parseBracket(readJsonText(path), path.string()); }

BracketFile parseShots(const std::string& text, const std::string& name) {
    const nlohmann::json json = parseJson(text, name);
    const JsonNode root(json, name, "");
    root.requireKeys({"camera", "response", "poses", "pictures"});
    BracketFile out;
    out.name = name;
    readCommon(root, out);
    std::optional<CameraTrack> track;
    if (root.has("poses")) track = readCameraTrack(besideFile(name, root.at("poses")));
    if (!track) (void)root.required("camera");
    if (!out.camera) out.camera = track->camera;
    for (const JsonNode& node : root.required("pictures").items(kMaxPictures)) {
        node.requireKeys({"file", "exposure", "R", "t"});
        ExposedPicture& picture = out.pictures.emplace_back(readPicture(name, node));
        picture.pose = !track || node.has("R") || node.has("t") ? poseOf(node) : poseNamed(*track, picture.file, node);
    }
    if (out.pictures.empty()) root.at("pictures").fail("is empty");
    return out;
}

BracketFile readShots(const std::filesystem::path& path) { return parseShots(readJsonText(path), path.string()); }

}  // namespace penumbra
