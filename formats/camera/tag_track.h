#pragma once
// The way of a camera past printed tags: its pose in every picture of a sequence.
//
// The first tag is the marker's frame. Where others lie is found from the pictures that see two of them, so that a
// picture needs any one of them, and several make its pose more exact.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/camera/camera_file.h"
#include "formats/camera/tag_detector.h"
#include "formats/camera/tag_pose.h"

namespace penumbra {

// The tags found in one picture.
struct TagFrame {
    std::string file;
    std::vector<DetectedTag> tags;  // only the chosen tags, each once
};

// Keeps of what was detected the tags that were chosen. Throws InvalidInput, which names the picture, where one of them
// is there twice.
TagFrame chosenTags(const std::string& file, std::span<const DetectedTag> found, std::span<const TagChoice> chosen);

// Where tags lie, one of each choice: x_marker = R x_tag + t. The first has no turn and no shift. None: it was never
// seen together with one whose place is known.
using TagPlaces = std::vector<std::optional<CameraPose>>;
TagPlaces placeTags(const PinholeCamera& camera, std::span<const TagChoice> chosen, std::span<const TagFrame> frames);

// The pose in the marker's frame. None: the picture has no tag whose place is known.
std::optional<PoseEstimate> poseInFrame(const PinholeCamera& camera, std::span<const TagChoice> chosen,
                                        const TagPlaces& places, const TagFrame& frame);

// Gives frames without a pose one between those of their neighbours: the camera's place on a straight line, its turn
// along the shortest arc. Frames before the first pose and after the last one stay without. Returns how many were
// filled.
std::size_t fillGaps(std::vector<TrackFrame>& frames);

// Smooths place and turn by a Gaussian whose standard deviation is `frames`. It looks as far ahead as back, so that it
// has no lag; frames without a pose are boundaries.
void smoothTrack(std::vector<TrackFrame>& track, double frames);

}  // namespace penumbra
