#pragma once
// Where the camera of a bracket stood, from a printed tag that its pictures show.
#include <span>

#include "formats/camera/tag_pose.h"
#include "formats/capture/paper_meter.h"

namespace penumbra {

struct BracketPose {
    PoseEstimate estimate;
    int pictures = 0;      // number of pictures whose corners were used
    bool clipped = false;  // the tag's paper is clipped in all of them: the pose is less exact
};
// Takes the corners in every picture whose paper is neither clipped nor dark, or else in the clipped ones, and fits one
// pose to all. Throws std::invalid_argument, which says what is wrong: no picture shows the tag, or one shows two.
BracketPose poseOfBracket(std::span<const TexturePicture> pictures, const PinholeCamera& camera,
                          const CameraResponse& response, const TagChoice& tag, int threads);

// Improves the pose by the edges of the tag's black square in the merged picture, which has less noise and no clipped
// paper (tag_edges.h). Returns `first` where they are not found.
BracketPose refineByEdges(const RadiancePicture& picture, const PinholeCamera& camera, const TagChoice& tag,
                          const BracketPose& first);

PaperTag paperOf(const TagChoice& tag);

}  // namespace penumbra
