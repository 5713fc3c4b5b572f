#include "formats/camera/camera_file.h"

#include <algorithm>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

using Json = nlohmann::ordered_json;
constexpr int kMaxSide = 32768;
constexpr std::size_t kMaxFrames = 1000000;
constexpr double kFar = 1e6, kMaxFocal = 1e7;

std::vector<double> doubles(const JsonNode& node, std::size_t count, double range) {
    const std::vector<JsonNode> all = node.items(count);
    if (all.size() != count) node.fail("must have " + std::to_string(count) + " numbers");
    std::vector<double> out;
    for (const JsonNode& one : all) out.push_back(one.number(-range, range));
    return out;
}

// Checks "format", and "version" where there is one: files that people write by hand have none. A file of another
// format is refused by its name.
void requireFormat(const JsonNode& root, const FileFormat& format) {
    const std::string found = root.required("format").text();
    if (found != format.name) root.at("format").fail("is \"" + found + "\", and not \"" + format.name + "\"");
    if (root.has("version")) root.requireVersion(format);
}

TrackFrame readFrame(const JsonNode& node) {
    node.requireKeys({"file", "R", "t", "margin", "residual", "filled"});
    TrackFrame out;
    if (node.has("file")) out.file = node.at("file").text();
    if (node.has("R") || node.has("t")) out.pose = poseOf(node);
    if (node.has("margin")) out.margin = node.at("margin").number(0, 1);
    if (node.has("residual")) out.residual = node.at("residual").number(0, kFar);
    if (node.has("filled")) out.filled = node.at("filled").flag();
    return out;
}

Json jsonOf(const PinholeCamera& camera) {
    return {{"f", camera.f},   {"cx", camera.cx}, {"cy", camera.cy}, {"size", {camera.width, camera.height}},
            {"k1", camera.k1}, {"k2", camera.k2}};
}

Json jsonOf(const TrackFrame& frame) {
    Json out{{"file", frame.file}};
    if (frame.pose) {
        const auto& m = frame.pose->rotation.m;
        const Vec3d t = frame.pose->translation;
        out["R"] = {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}};
        out["t"] = {t.x, t.y, t.z};
        out["margin"] = frame.margin;
        out["residual"] = frame.residual;
    }
    if (frame.filled) out["filled"] = true;
    return out;
}

std::string textOf(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

CameraResponse parseResponse(const std::string& text, const std::string& name) {
    const nlohmann::json json = parseJson(text, name);
    const JsonNode root(json, name, "");
    requireFormat(root, kResponseFormat);
    root.requireKeys({"format", "version", "exposure"});
    CameraResponse out;
    const std::vector<JsonNode> channels = root.required("exposure").items(3);
    if (channels.size() != 3) root.at("exposure").fail("must have 3 channels");
    for (std::size_t c = 0; c < 3; ++c) {
        const std::vector<float> curve = channels[c].numbers(256, 0, kFar);
        std::ranges::copy(curve, out.exposure[c].begin());
        if (!std::ranges::is_sorted(curve)) channels[c].fail("falls where the code grows");
        if (!(curve.front() < curve.back())) channels[c].fail("is the same for every code");
    }
    return out;
}

}  // namespace

PinholeCamera cameraOf(const JsonNode& node, std::initializer_list<const char*> more) {
    node.requireKeys({"f", "cx", "cy", "size", "k1", "k2"}, more);
    PinholeCamera out;
    const std::vector<JsonNode> size = node.required("size").items(2);
    if (size.size() != 2) node.at("size").fail("must have 2 numbers");
    out.width = size[0].whole(1, kMaxSide);
    out.height = size[1].whole(1, kMaxSide);
    out.f = node.required("f").number(1e-3, kMaxFocal);
    out.cx = node.has("cx") ? node.at("cx").number(-kFar, kFar) : (out.width - 1) / 2.0;
    out.cy = node.has("cy") ? node.at("cy").number(-kFar, kFar) : (out.height - 1) / 2.0;
    if (node.has("k1")) out.k1 = node.at("k1").number(-kFar, kFar);
    if (node.has("k2")) out.k2 = node.at("k2").number(-kFar, kFar);
    if (const std::string problem = findProblem(out); !problem.empty()) node.fail(problem);
    return out;
}

CameraPose poseOf(const JsonNode& node) {
    CameraPose out;
    const std::vector<JsonNode> rows = node.required("R").items(3);
    if (rows.size() != 3) node.at("R").fail("must have 3 rows");
    for (std::size_t i = 0; i < 3; ++i) {
        const std::vector<double> row = doubles(rows[i], 3, 2);
        std::ranges::copy(row, out.rotation.m.begin() + std::ptrdiff_t(3 * i));
    }
    const std::vector<double> t = doubles(node.required("t"), 3, kFar);
    out.translation = {t[0], t[1], t[2]};
    if (const std::string problem = findProblem(out); !problem.empty()) node.fail(problem);
    return out;
}

PinholeCamera readCamera(const std::filesystem::path& path) {
    const nlohmann::json json = parseJson(readJsonText(path), path.string());
    const JsonNode root(json, path.string(), "");
    if (root.has("format")) requireFormat(root, kCameraFormat);
    return cameraOf(root, {"format", "version"});
}

PinholeCamera cameraOrFile(const JsonNode& node, const std::string& json_file) {
    if (!node.isObject()) return readCamera(std::filesystem::path(json_file).parent_path() / node.text());
    if (node.has("format")) requireFormat(node, kCameraFormat);
    return cameraOf(node, {"format", "version"});
}

std::string cameraText(const PinholeCamera& camera) {
    Json out{{"format", kCameraFormat.name}, {"version", kCameraFormat.version}};
    out.update(jsonOf(camera));
    return textOf(out);
}

CameraTrack parseCameraTrack(const std::string& text, const std::string& name) {
    const nlohmann::json json = parseJson(text, name);
    const JsonNode root(json, name, "");
    requireFormat(root, kCameraPosesFormat);
    root.requireKeys({"format", "version", "camera", "frames"});
    CameraTrack out;
    out.camera = cameraOf(root.required("camera"));
    for (const JsonNode& frame : root.required("frames").items(kMaxFrames)) out.frames.push_back(readFrame(frame));
    if (out.frames.empty()) root.at("frames").fail("is empty");
    return out;
}

CameraTrack readCameraTrack(const std::filesystem::path& path) {
    return parseCameraTrack(readJsonText(path), path.string());
}

std::string cameraTrackText(const CameraTrack& track) {
    Json frames = Json::array();
    for (const TrackFrame& frame : track.frames) frames.push_back(jsonOf(frame));
    return textOf({{"format", kCameraPosesFormat.name},
                   {"version", kCameraPosesFormat.version},
                   {"camera", jsonOf(track.camera)},
                   {"frames", std::move(frames)}});
}

CameraResponse readResponse(const std::string& name_or_file) {
    if (const std::optional<CameraResponse> known = knownResponse(name_or_file)) return *known;
    return parseResponse(readJsonText(name_or_file), name_or_file);
}

std::string responseText(const CameraResponse& response) {
    return textOf(
        {{"format", kResponseFormat.name}, {"version", kResponseFormat.version}, {"exposure", response.exposure}});
}

}  // namespace penumbra
