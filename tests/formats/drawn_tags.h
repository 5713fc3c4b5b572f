#pragma once
// Pictures of tags as a camera would see them, drawn from the codes of the families.
#include <span>

#include "formats/camera/tag_detector.h"
#include "formats/camera/tag_pose.h"
#include "sh/camera_response.h"

namespace penumbra::samples {

struct DrawnTag {
    TagFamily family = TagFamily::k36h11;
    int id = 0;
    double side = 1;
    Vec3d place = {};  // its middle, in the plane z = 0
};

struct Photograph {
    PinholeCamera camera{640, 319.5, 239.5, 640, 480, 0, 0};
    CameraPose pose;
    CameraResponse response = *knownResponse("srgb");
    double paper = 0.6, floor = 0.25, noise = 0;  // light, as a part of what saturates
};

// Four by four rays a pixel.
TexturePicture photographOf(const Photograph& taken, std::span<const DrawnTag> tags);

// A camera that stands at `eye` and looks at `target`, upright; marker frame, z up.
CameraPose lookingAt(Vec3d eye, Vec3d target);

}  // namespace penumbra::samples
