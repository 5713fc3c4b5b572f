#pragma once
// Follows a camera by printed tags, picture by picture, for a window.
#include <optional>
#include <vector>

#include "formats/camera/tag_detector.h"
#include "formats/camera/tag_pose.h"

namespace penumbra {

struct TrackedPose {
    std::optional<CameraPose> pose;  // the last one that was found; none before the first
    bool seen = false;               // in this picture
    double margin = 0, residual = 0;
    double milliseconds = 0;  // that finding tags and the pose took
    bool clipped = false;     // the tag's paper is clipped
};

class LiveTracker {
public:
    // `tags` has at least one; the first is the marker's frame. Others are used once they were seen together with it.
    LiveTracker(const PinholeCamera& camera, std::vector<TagChoice> tags, const CameraResponse& response, int threads);
    const TrackedPose& track(const TexturePicture& picture);

private:
    PinholeCamera camera_;
    std::vector<TagChoice> tags_;
    std::vector<std::optional<CameraPose>> places_;  // x_marker = R x_tag + t, of each tag
    CameraResponse response_;
    TagDetector detector_;
    TrackedPose last_;
};

}  // namespace penumbra
