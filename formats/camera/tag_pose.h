#pragma once
// The pose of a camera from corners of tags: where points of the marker's frame appear in a picture.
//
// A flat tag that is small in the picture fits two poses, which are near mirror images about the line of sight. Both
// are found, and the margin says how much better the returned one fits.
#include <span>
#include <vector>

#include "formats/camera/tag_detector.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

// A point of the marker's frame in metres, and where it is seen.
struct SeenPoint {
    Vec3d point;
    PixelPoint pixel;
};

struct PoseEstimate {
    CameraPose pose;
    double residual = 0;  // rms distance between where points are seen and where they should be, pixels
    double margin = 0;    // 1 - residual / that of the mirrored pose, 0..1
};

// The corners of a tag of this side in its own frame, in the order of DetectedTag::corners.
std::array<Vec3d, 4> tagCorners(double side);
std::vector<SeenPoint> seenCorners(const DetectedTag& tag, double side);

// Returns the pose that puts points of the plane z = 0 where they are seen: a homography without the lens
// (direct linear transformation), and from there Levenberg-Marquardt on the distances in the picture, lens included.
// Needs four points or more, no three of four on a line. None where no pose in front of the camera fits.
std::optional<PoseEstimate> estimatePose(const PinholeCamera& camera, std::span<const SeenPoint> points);
// Improves a pose for points anywhere in space. The margin stays 0.
PoseEstimate refinePose(const PinholeCamera& camera, std::span<const SeenPoint> points, const CameraPose& start);

}  // namespace penumbra
