#pragma once
// Follows a camera by printed tags, picture by picture, for a window.
#include <optional>
#include <vector>

#include "formats/camera/tag_detector.h"
#include "formats/camera/tag_pose.h"
#include "formats/camera/tag_track.h"

namespace penumbra {

struct TrackedPose {
    std::optional<CameraPose> pose;  // the last one that was found; none before the first
    bool seen = false;               // in this picture
    double margin = 0, residual = 0;
    double milliseconds = 0;  // time to find tags and the pose
    bool clipped = false;     // the tag's paper is clipped
    bool twice = false;       // the picture shows two tags of one id, neither of which is used
};

class LiveTracker {
public:
    // `tags` has at least one; the first is the marker's frame. Others are used once they were seen together with it,
    // at a margin that tells the pose from its mirror; where they lie is the mean of the first pictures that show so.
    LiveTracker(const PinholeCamera& camera, std::vector<TagChoice> tags, const CameraResponse& response, int threads);
    const TrackedPose& track(const TexturePicture& picture);

private:
    PinholeCamera camera_;
    std::vector<TagChoice> tags_;
    TagPlaces places_;                // x_marker = R x_tag + t, of each tag
    std::vector<TagFrame> together_;  // the first pictures with several tags, from which places_ follow
    CameraResponse response_;
    TagDetector detector_;
    TrackedPose last_;

    TagFrame tagsIn(const TexturePicture& picture);
    void learnPlaces(const TagFrame& frame);
};

}  // namespace penumbra
