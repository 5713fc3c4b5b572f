#pragma once
// JSON files of real cameras: cam.json, the poses.json of a track, and cam.response.json (formats/README.md lists the
// keys). Every reader throws IoError, and InvalidInput with the file, the JSON pointer and what is wrong.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/json_node.h"
#include "sh/camera_response.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

constexpr FileFormat kCameraFormat{"penumbra.camera", 1};
constexpr FileFormat kCameraPosesFormat{"penumbra.camera_poses", 1};
constexpr FileFormat kResponseFormat{"penumbra.camera_response", 1};

// One picture of a track.
struct TrackFrame {
    std::string file;  // name of the file when the track was made; "" if the track has no files
    // None: no tag was found here, and the gap was not filled.
    std::optional<CameraPose> pose;
    double margin = 0;    // how much better this pose fits than its mirror: 1 - error / error of the other, 0..1
    double residual = 0;  // rms of the corners, pixels
    bool filled = false;  // interpolated between its neighbours
};

struct CameraTrack {
    PinholeCamera camera;
    std::vector<TrackFrame> frames;  // at least one
};

PinholeCamera readCamera(const std::filesystem::path& path);
// The same for a JSON object that another file holds. It may have more keys than a camera's, which `more` lists.
PinholeCamera cameraOf(const JsonNode& node, std::initializer_list<const char*> more = {});
// Returns the camera that another file holds or names: an object as in cam.json, whose format and version may stand
// there, or the path of a cam.json as seen from the folder of `json_file`.
PinholeCamera cameraOrFile(const JsonNode& node, const std::string& json_file);
// Returns the pose that the keys "R" and "t" of an object say.
CameraPose poseOf(const JsonNode& node);
std::string cameraText(const PinholeCamera& camera);

// Refuses poses of bones (bone_poses.h) by that name.
CameraTrack readCameraTrack(const std::filesystem::path& path);
CameraTrack parseCameraTrack(const std::string& text, const std::string& name);
std::string cameraTrackText(const CameraTrack& track);

// Returns the response of a known name ("srgb", "linear", "rec709") or of a file.
CameraResponse readResponse(const std::string& name_or_file);
std::string responseText(const CameraResponse& response);

}  // namespace penumbra
