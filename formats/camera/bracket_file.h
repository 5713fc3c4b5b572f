#pragma once
// JSON files that list photographs and their exposures: BRACKET.json (one camera, one place, several exposures) and
// SHOTS.json (a walk around: every picture has a pose of its own). formats/README.md lists the keys.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sh/pinhole_camera.h"

namespace penumbra {

struct ExposedPicture {
    std::filesystem::path file;      // found from the folder of the JSON file
    double exposure = 0;             // code = response(radiance times exposure), > 0; seconds, or any other unit
    std::optional<CameraPose> pose;  // always set in a walk around, never in a bracket
};

// A BRACKET.json or a SHOTS.json.
struct BracketFile {
    std::string name;                      // name of the file, for messages
    std::optional<PinholeCamera> camera;   // always there in a walk around
    std::string response;                  // "srgb", "linear", "rec709", "find", "" (not said), or a path to a file
    std::string tag;                       // in a bracket "FAMILY:ID:SIDE", which parseTag() reads, or ""
    std::optional<CameraPose> pose;        // only in a bracket, and never beside a tag
    std::vector<ExposedPicture> pictures;  // at least one
};

// "camera" is an object as in cam.json, or the path of one. Reads {"camera", "response", "tag" or "R" and "t",
// "pictures": [{"file", "exposure"}]}. All but the pictures may be missing. Exposures must all rise or all fall, and
// need at least two pictures. Throws IoError, and InvalidInput with the file, the JSON pointer and what is wrong.
BracketFile readBracket(const std::filesystem::path& path);
BracketFile parseBracket(const std::string& text, const std::string& name);

// Reads {"camera": {..}, "response", "poses": "poses.json", "pictures": [{"file", "exposure", "R", "t"}]}. The response
// may be missing. With "poses", so may the camera, and R and t of pictures whose file the poses name.
BracketFile readShots(const std::filesystem::path& path);
BracketFile parseShots(const std::string& text, const std::string& name);

}  // namespace penumbra
