#pragma once
// Finds printed square tags in a picture, by libapriltag. Detection works on linear light: in the codes of a picture
// the black squares of a tag shrink by a third of a pixel a side.
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/image/texture_file.h"
#include "sh/camera_response.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

enum class TagFamily { k36h11, k25h9, k16h5, k4x4_50 };  // the last is ArUco's DICT_4X4_50

// A tag that lies in the scene: which, and how long its black square's side is, in metres.
struct TagChoice {
    TagFamily family = TagFamily::k36h11;
    int id = 0;
    double side = 0;
};
const char* nameOf(TagFamily family);  // "36h11"
std::optional<TagFamily> findTagFamily(std::string_view name);
// Reads "FAMILY:ID:SIDE", as "36h11:3:0.7". Throws BadOption.
TagChoice parseTag(const std::string& text);

struct DetectedTag {
    TagFamily family = TagFamily::k36h11;
    int id = 0;
    // The corners of the black square, as they lie on the paper: lower left, lower right, upper right, upper left. In
    // the marker's frame these are (-s, -s), (s, -s), (s, s), (-s, s), s = side / 2.
    std::array<PixelPoint, 4> corners{};
    double decision_margin = 0;  // libapriltag's: how clearly its bits are read
    int flipped_bits = 0;
    float paper_code = 0;  // highest code (0..255, any channel) of the white around the tag: above 250 it is clipped
};

// The luminance of a picture in linear light: weights Rec.709 over the channels, each code through the response. In
// [0,1] of what saturates.
struct LinearLuminance {
    int width = 0, height = 0;
    std::vector<float> values;  // [height, width]
};
LinearLuminance linearLuminance(const TexturePicture& picture, const CameraResponse& response);

class TagDetector {
public:
    // Throws std::invalid_argument for no family. `threads` >= 1 of libapriltag's own.
    explicit TagDetector(std::span<const TagFamily> families, int threads = 1);
    ~TagDetector();
    TagDetector(const TagDetector&) = delete;
    TagDetector& operator=(const TagDetector&) = delete;

    // Returns every tag of these families, by family and id, corners refined. A tag that is seen twice stands twice.
    std::vector<DetectedTag> detect(const TexturePicture& picture, const CameraResponse& response);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace penumbra
